// The first script that runs: unpack the libraries, then start the page.

import { blob } from "./blobs";

type Libraries = Record<string, unknown>;
const shared = globalThis as unknown as {
  r3gwLibraries: Libraries;
  r3gwPage: (require: (name: string) => unknown) => void;
};

async function boot(): Promise<void> {
  const code = new Blob([await blob("libraries")], { type: "text/javascript" });
  const url = URL.createObjectURL(code);
  await new Promise<void>((resolve, reject) => {
    const script = document.createElement("script");
    script.src = url;
    script.onload = () => resolve();
    script.onerror = () => reject(new Error("the page's libraries do not run"));
    document.head.append(script);
  });
  URL.revokeObjectURL(url);
  shared.r3gwPage((name) => shared.r3gwLibraries[name]);
}

boot().catch((error: unknown) => {
  const message = document.getElementById("message");
  if (message) message.textContent = `This page could not start: ${String(error)}`;
  console.error(error);
});
