// The libraries of the page, built once into vendor.js.gz; page.js asks them by their npm names.
import * as spark from "@sparkjsdev/spark";
import * as three from "three";
import * as orbit from "three/addons/controls/OrbitControls.js";
import * as exr from "three/addons/loaders/EXRLoader.js";
import * as hdr from "three/addons/loaders/HDRLoader.js";

(globalThis as Record<string, unknown>).r3gwLibraries = {
  three,
  "@sparkjsdev/spark": spark,
  "three/addons/controls/OrbitControls.js": orbit,
  "three/addons/loaders/EXRLoader.js": exr,
  "three/addons/loaders/HDRLoader.js": hdr,
};
