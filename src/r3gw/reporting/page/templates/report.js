"use strict";
// Sun slider: shows the frame that the slider stands at. Frames lie beside it as JSON.
for (const strip of document.querySelectorAll("[data-strip]")) {
  const frames = JSON.parse(strip.querySelector("script").textContent);
  const input = strip.querySelector("input");
  const output = strip.querySelector("output");
  const views = strip.querySelectorAll("img.view");
  const maps = strip.querySelectorAll("img.map");
  const show = () => {
    const frame = frames[Number(input.value)];
    views.forEach((image, i) => { image.src = frame.views[i]; });
    maps.forEach((image) => { image.src = frame.map; });
    output.textContent = `${frame.yaw_deg}°`;
    input.setAttribute("aria-valuetext", `turned by ${frame.yaw_deg} degrees`);
  };
  input.addEventListener("input", show);
  show();
}
// Mask switches.
for (const box of document.querySelectorAll("input[data-masks]")) {
  const photos = document.getElementById(box.dataset.masks);
  const show = () => photos.classList.toggle("no-masks", !box.checked);
  box.addEventListener("change", show);
  show();
}
