"use strict";
// Mask switches.
for (const box of document.querySelectorAll("input[data-masks]")) {
  const photos = document.getElementById(box.dataset.masks);
  const show = () => photos.classList.toggle("no-masks", !box.checked);
  box.addEventListener("change", show);
  show();
}
