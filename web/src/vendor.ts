// The libraries of the page, built once into vendor.js.gz; page.js asks them by their npm names.
import * as spark from "@sparkjsdev/spark";
import * as three from "three";
import * as orbit from "three/addons/controls/OrbitControls.js";

(globalThis as Record<string, unknown>).r3gwLibraries = {
  three,
  "@sparkjsdev/spark": spark,
  "three/addons/controls/OrbitControls.js": orbit,
};
