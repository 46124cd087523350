// Start of the page: data in, controller and controls connected.

import { jsonBlob } from "./blobs";
import { App } from "./app";
import { connect } from "./controls";
import { Lights } from "./lights";
import type { Payload } from "./payload";
import { makeSplats } from "./splats";
import { Stage } from "./stage";
import { makeUniforms } from "./uniforms";
import { Witnesses } from "./witnesses";

async function start(): Promise<void> {
  const payload = await jsonBlob<Payload>("payload");
  const uniforms = makeUniforms(payload);
  const splats = await makeSplats(payload, uniforms);
  const canvas = document.querySelector<HTMLCanvasElement>("#canvas")!;
  const witnesses = await Witnesses.of(payload, uniforms);
  const stage = new Stage(canvas, splats, uniforms, payload.constants, witnesses);
  await stage.prepare();
  const app = new App(payload, stage, new Lights(payload, uniforms), canvas);
  connect(app);
  await stage.settle();
  document.body.classList.add("ready");
  performance.mark("r3gw-ready");
  (globalThis as Record<string, unknown>).r3gwApp = app;
}

start().catch((error: unknown) => {
  const reason = error instanceof Error ? error.message : String(error);
  document.getElementById("message")!.textContent =
    `The scene cannot be shown: ${reason}. It needs a browser with WebGL 2.`;
  console.error(error);
});
