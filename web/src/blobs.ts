// Binary data embedded in the page: base64 text of deflated bytes, in <script> elements that no
// browser runs. Decoding gives way to the page every few milliseconds.

const CHUNK = 1 << 18; // base64 characters at a time; a multiple of 4
const pause = () => new Promise<void>((resolve) => setTimeout(resolve, 0));

export function hasBlob(id: string): boolean {
  return document.getElementById(id) !== null;
}

/** The bytes of an embedded blob; its text is let go of. */
export async function blob(id: string): Promise<Uint8Array<ArrayBuffer>> {
  const element = document.getElementById(id);
  if (!element) throw new Error(`this page lacks its part "${id}"`);
  const text = (element.textContent ?? "").trim();
  element.textContent = "";
  const parts: BlobPart[] = [];
  for (let start = 0; start < text.length; start += CHUNK) {
    parts.push(bytesOf(text.slice(start, start + CHUNK)));
    await pause();
  }
  const stream = new Blob(parts).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The JSON value of an embedded blob. */
export async function jsonBlob<T>(id: string): Promise<T> {
  return JSON.parse(new TextDecoder().decode(await blob(id))) as T;
}

function bytesOf(base64: string): Uint8Array<ArrayBuffer> {
  const binary = atob(base64);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}
