import { readFileSync } from "node:fs";
import type { Mesh, MeshBasicMaterial } from "three";
import { expect, it } from "vitest";
import { drawFrustum, fadeFrustum, picturePart } from "../../../src/elements/scene/frustum-layer.js";
import { readCameraInfo } from "../../../src/scene/camera-model.js";
import { MessageReader } from "../../../src/scene/cdr.js";

const RECORDED = JSON.parse(readFileSync(new URL("../../scene/recorded.json", import.meta.url), "utf8")) as Record<string, string>;

it("shows a picture faded that is not of the moment, whether older or of a later one", () => {
  const info = readCameraInfo(new MessageReader(Uint8Array.from(atob(RECORDED["camera_info"] ?? ""), (letter) => letter.charCodeAt(0)), "cdr"));
  const image = { width: 4, height: 4 } as ImageBitmap;
  const drawn = drawFrustum({ shape: "camera", info, picture: { image, timeUs: 1, heardMs: 10_000, rectified: false } }, { accent: "#ffffff", night: false });
  const faded = [1000, 9000, 11_000, 13_000].map((nowMs) => {
    fadeFrustum(drawn, nowMs);
    return (picturePart(drawn) as Mesh<never, MeshBasicMaterial>).material.opacity < 1;
  });
  expect(faded).toEqual([true, false, false, true]);
});
