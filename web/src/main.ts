import { jsonBlob } from "./blobs";
import { lensOf, poseOf, project, type Lens } from "./camera";
import { Lights } from "./lights";
import { readMap } from "./maps";
import type { Payload } from "./payload";
import { makeSplats } from "./splats";
import { Stage } from "./stage";
import type { State } from "./state";
import { makeUniforms } from "./uniforms";

async function start(): Promise<void> {
  const payload = await jsonBlob<Payload>("payload");
  const uniforms = makeUniforms(payload);
  const splats = await makeSplats(payload, uniforms);
  const canvas = document.querySelector<HTMLCanvasElement>("#canvas")!;
  const stage = new Stage(canvas, splats, uniforms, payload.constants);
  const lights = new Lights(payload, uniforms);
  const first = payload.photos[0];
  let lens: Lens = lensOf(first);
  const api = {
    payload, stage, lights, uniforms,
    async picture(state: State, photo: string, width: number, height: number): Promise<string> {
      const found = payload.photos.find((p) => p.name === photo)!;
      lens = lensOf(found);
      const pose = poseOf(found);
      stage.camera.position.copy(pose.position);
      stage.camera.quaternion.copy(pose.quaternion);
      stage.renderer.setDrawingBufferSize(width, height, 1);
      project(stage.camera, lens, width / height, payload.constants.nearPlane, 1e4);
      lights.apply(state);
      await stage.settle();
      return canvas.toDataURL("image/png");
    },
    async drop(file: File) { lights.dropped = await readMap(file, payload.constants.gamma); },
  };
  (globalThis as Record<string, unknown>).r3gw = api;
  stage.request();
}
void start();
