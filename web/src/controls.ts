// The page's controls: thumbnails, dome, drop zone, buttons; all text is in the markup.

import type { App } from "./app";
import { frameIn, lensOf } from "./camera";
import { Dome } from "./dome";
import { Form } from "./form";
import { MapReader } from "./maps";
import type { Photo } from "./payload";
import { Strip } from "./strip";

const DAY_S = 20;

function element<T extends Element = HTMLElement>(id: string): T {
  const found = document.querySelector<T>(`#${id}`);
  if (!found) throw new Error(`the page lacks its element "${id}"`);
  return found;
}

export function say(text: string): void {
  element("message").textContent = text;
}

export function connect(app: App): void {
  const { payload } = app;
  const form = new Form(element<HTMLFormElement>("controls"), (part) => app.change(part));
  const dome = new Dome(element<SVGSVGElement>("dome"), (value) => app.change(value));
  const lit = payload.photos.filter((photo) => payload.lights.some((l) => l.photo === photo.name));
  const lights = new Strip(element("lights"), lit, (photo) => `Light of ${photo.name}`,
    (photo) => app.change({ light: "learned", photo }));
  const cameras = new Strip(element("cameras"), payload.photos, (photo) => `View of ${photo.name}`,
    (photo) => void app.jump(photo));
  fillBlend(lit);
  const fade = connectFade();
  app.view = {
    show(state) {
      form.show(state);
      dome.show(state);
      lights.mark(state.light === "learned" ? state.photo : null);
    },
    atPhoto(photo) {
      cameras.mark(photo?.name ?? null);
      fade(photo);
    },
    look(azimuth) {
      dome.look(azimuth);
    },
    coverage(sentence) {
      element("coverage").textContent = sentence;
    },
  };
  connectMap(app);
  connectDay(app);
  connectButtons(app);
  connectFacts(app);
  app.view.show(app.state);
}

function fillBlend(lit: Photo[]): void {
  const select = element<HTMLSelectElement>("photo2");
  for (const { name } of lit) select.append(new Option(name, name));
}

/** The photo over the canvas: opacity by a slider that works at a photo's camera. */
function connectFade(): (photo: Photo | null) => void {
  const image = element<HTMLImageElement>("photo");
  const slider = element<HTMLInputElement>("fade");
  const canvas = element<HTMLCanvasElement>("canvas");
  let shown: Photo | null = null;
  const place = () => {
    image.hidden = !shown?.picture || slider.value === "0";
    if (!shown?.picture) return;
    if (!image.hidden && image.src !== shown.picture) image.src = shown.picture;
    const frame = frameIn(lensOf(shown), canvas.clientWidth / canvas.clientHeight);
    image.style.opacity = slider.value;
    image.style.width = `${100 * frame.width}%`;
    image.style.height = `${100 * frame.height}%`;
  };
  slider.addEventListener("input", place);
  new ResizeObserver(place).observe(canvas);
  return (photo) => {
    shown = photo;
    slider.disabled = !photo?.picture;
    place();
  };
}

function connectMap(app: App): void {
  const reader = new MapReader(app.payload.constants.gamma);
  const input = element<HTMLInputElement>("map-file");
  const take = async (file: File | undefined) => {
    if (!file) return;
    say(`Reading ${file.name} …`);
    try {
      app.useMap(await reader.read(file));
      element("map-name").textContent = file.name;
      say("");
    } catch (error) {
      say(error instanceof Error ? error.message : String(error));
    }
  };
  input.addEventListener("change", () => {
    void take(input.files?.[0]);
    input.value = "";
  });
  addEventListener("dragover", (event) => {
    event.preventDefault();
    document.body.classList.add("dropping");
  });
  addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) document.body.classList.remove("dropping");
  });
  addEventListener("drop", (event) => {
    event.preventDefault();
    document.body.classList.remove("dropping");
    void take(event.dataTransfer?.files[0]);
  });
}

function connectDay(app: App): void {
  const button = element<HTMLButtonElement>("day");
  const set = (isPlaying: boolean) => {
    button.setAttribute("aria-pressed", String(isPlaying));
    button.textContent = isPlaying ? "Stop the day" : "Play a day";
  };
  button.addEventListener("click", () => {
    const isPlaying = button.getAttribute("aria-pressed") === "true";
    set(app.playDay(isPlaying ? 0 : DAY_S, () => set(false)));
  });
}

function connectButtons(app: App): void {
  const canvas = element<HTMLCanvasElement>("canvas");
  element("save").addEventListener("click", async () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await app.picture());
    link.download = `${app.payload.title}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  });
  element("copy").addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(location.href);
      say("The link to this view is copied.");
    } catch {
      say("The address bar holds the link to this view.");
    }
  });
  for (const radio of document.querySelectorAll<HTMLInputElement>("[data-mode]")) {
    radio.addEventListener("change", () => {
      app.navigation.setMode(radio.dataset.mode === "fly" ? "fly" : "orbit");
      canvas.focus();
    });
  }
}

function connectFacts(app: App): void {
  const { payload } = app;
  const count = payload.numForeground + payload.numSky;
  const left = payload.numLeftOut
    ? ` ${payload.numLeftOut.toLocaleString("en")} more were left out of this page, the least ` +
      "visible ones, so that it stays quick."
    : "";
  const shadows = payload.hasShadows
    ? "Shadows come from what each Gaussian sees of the sky; they are soft."
    : "This model casts no shadows: light is distant and nothing is in its way.";
  const facts = [`${count.toLocaleString("en")} Gaussians.${left}`, shadows, ...payload.facts];
  const list = element("facts");
  for (const fact of facts) list.append(Object.assign(document.createElement("li"), { textContent: fact }));
  if (left) say(left.trim());
  element("licences").textContent = payload.licences;
}
