// Rows of photo thumbnails: one to pick a light, one to jump to a camera.

import type { Photo } from "./payload";

export class Strip {
  private readonly buttons = new Map<string, HTMLButtonElement>();

  constructor(
    parent: HTMLElement,
    photos: Photo[],
    describe: (photo: Photo) => string,
    onPick: (photo: string) => void,
  ) {
    for (const photo of photos) {
      const button = document.createElement("button");
      button.type = "button";
      button.title = photo.name;
      button.setAttribute("aria-label", describe(photo));
      button.setAttribute("aria-pressed", "false");
      button.append(pictureOf(photo));
      button.addEventListener("click", () => onPick(photo.name));
      this.buttons.set(photo.name, button);
      parent.append(button);
    }
  }

  /** Mark one photo, or none. */
  mark(name: string | null): void {
    for (const [photo, button] of this.buttons) {
      button.setAttribute("aria-pressed", String(photo === name));
    }
  }
}

function pictureOf(photo: Photo): HTMLElement {
  if (!photo.thumbnail) {
    const text = document.createElement("span");
    text.textContent = photo.name;
    return text;
  }
  const picture = new Image();
  picture.alt = "";
  picture.loading = "lazy";
  picture.decoding = "async";
  picture.src = photo.thumbnail;
  return picture;
}
