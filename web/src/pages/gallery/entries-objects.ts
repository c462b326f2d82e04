/** Objects on pictures, and sightings, in each of their states. */

import { html, type TemplateResult } from "lit";
import { styled } from "../../elements/base/style-directive.js";
import "../../elements/camera/detection-boxes.js";
import type { FramedObject } from "../../elements/camera/detection-boxes.js";
import "../../elements/camera/model-overlay.js";
import "../../elements/camera/models-strip.js";
import type { ModelRow } from "../../elements/camera/models-strip.js";
import type { PictureOverlay } from "../../elements/camera/overlay-layer.js";
import type { PictureModelShape } from "../../generated/api.js";
import type { OverlayLayer } from "../../generated/wire.js";
import "../../elements/camera/objects-overlay.js";
import type { DetectorState } from "../../elements/camera/objects-overlay.js";
import "../../elements/camera/objects-choice.js";
import type { ObjectOption } from "../../elements/camera/objects-choice.js";
import "../../elements/analysis/sighting-card.js";
import type { SightingFacts } from "../../elements/analysis/sighting-card.js";
import "../../elements/analysis/path-sketch.js";
import type { PictureMark } from "../../elements/camera/mark-shapes.js";
import "../../elements/camera/picture-marks.js";
import type { SightingStory } from "../../format/object-names.js";
import type { GalleryEntry } from "./entry.js";

const NOON_US = 1_780_000_000_000_000;
const box = (label: string, score: number, left: number, top: number, right: number, bottom: number): FramedObject => ({ label, score, left, top, right, bottom });
const THINGS: readonly FramedObject[] = [
  box("person", 0.92, 0.1, 0.15, 0.35, 0.95),
  box("dog", 0.71, 0.42, 0.6, 0.64, 0.92),
  box("car", 0.55, 0.66, 0.02, 0.97, 0.4),
  box("chair", 0.34, 0.72, 0.62, 0.95, 0.9),
];
const CLASSES: readonly ObjectOption[] = [
  { label: "person", wanted: true, described: true },
  { label: "dog", wanted: true, described: true },
  { label: "car", wanted: false, described: true },
  { label: "chair", wanted: false, described: false },
];

function renderBoxed(things: readonly FramedObject[], earlier = false, zoom = { scale: 1, x: 0, y: 0 }, ground = "linear-gradient(#fff, #9aa, #000)"): TemplateResult {
  return html`<div ${styled({ position: "relative", "aspect-ratio": "4 / 3", background: ground })}>
    <t-boxes .things=${things} ?earlier=${earlier} .zoom=${zoom}></t-boxes>
  </div>`;
}

function renderMarked(ground: string): TemplateResult {
  return html`<div ${styled({ position: "relative", "aspect-ratio": "4 / 3", background: ground })}>
    <t-picture-marks .marks=${MARKS}></t-picture-marks>
  </div>`;
}

function renderObjects(on: boolean, detector: DetectorState, counts: readonly { label: string; many: number }[], busy = false): TemplateResult {
  return html`<div ${styled({ "block-size": "6rem", background: "#667" })}>
    <t-objects ?on=${on} detector=${detector} why="/gallery" .counts=${counts} ?busy=${busy}></t-objects>
  </div>`;
}

const SEEN: SightingFacts = { label: "person", many: 2, confidence: 0.87, began_us: NOON_US, ended_us: NOON_US + 185e6 };
/** A grey picture, so that nothing need be fetched. */
const STORY: SightingStory = {
  path: [{ x: 0.1, y: 0.9 }, { x: 0.3, y: 0.7 }, { x: 0.5, y: 0.68 }, { x: 0.8, y: 0.4 }],
  stays: [{ zone: "Charging place", entries: 2, dwell_s: 72 }],
  crossings: [{ line: "Door", left: 2, right: 1 }],
  speed: 1.24,
};
const MARKS: readonly PictureMark[] = [
  { kind: "zone", id: "mat", name: "Charging place", points: [[0.3, 0.6], [0.6, 0.6], [0.7, 1], [0.2, 1]], counts: ["1 person", "longest 12 s"] },
  { kind: "line", id: "door", name: "Door", points: [[0.75, 0.9], [0.85, 0.3]], counts: ["left 3", "right \u2013"] },
];
const PICTURE = "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 4 3'%3E%3Crect width='4' height='3' fill='%23789'/%3E%3Crect x='1.4' y='.6' width='.6' height='1.9' fill='%23342'/%3E%3C/svg%3E";

function renderSeen(more: Partial<SightingFacts>, picture = ""): TemplateResult {
  return html`<t-sighting .sighting=${{ ...SEEN, ...more }} camera="Front camera" picture=${picture} zone="Europe/Madrid"><a href="/gallery">Chart</a></t-sighting>`;
}

const NO_LAYER: OverlayLayer = { t: "layer", rows: 0, columns: 0, runs: new Uint8Array(), near: null, far: null, poses: [], likely: [] };

function modelOf(kind: PictureModelShape["kind"], more: Partial<PictureModelShape> = {}): PictureModelShape {
  return { id: kind, kind, classes: [], points: [], bones: [], confidence: 0.5, max_rate: 5, zones: [], ...more };
}

/** A map of 60 by 80 cells, each by its place (0 to 1). */
function mapOf(valueAt: (x: number, y: number) => number, more: Partial<OverlayLayer> = {}): OverlayLayer {
  const cells = Array.from({ length: 4800 }, (_, at) => valueAt((at % 80) / 80, Math.floor(at / 80) / 60));
  return { ...NO_LAYER, rows: 60, columns: 80, runs: Uint8Array.from(cells.flatMap((value) => [1, value])), ...more };
}

const GROUND = modelOf("segmentation", { classes: ["background", "floor", "wall", "door"] });
const GROUND_LAYER = mapOf((x, y) => (y > 0.55 + Math.abs(x - 0.5) * 0.3 ? 1 : x < 0.3 ? 2 : x > 0.7 && x < 0.9 && y > 0.2 ? 3 : 0));
const SKELETON = [[0, 1], [1, 2], [1, 3], [1, 4], [4, 5], [4, 6]] as const;
const POSE = modelOf("keypoints", {
  classes: ["person"],
  points: ["head", "neck", "left hand", "right hand", "hip", "left foot", "right foot"],
  bones: SKELETON.map(([start, end]) => ({ start, end })),
});
const POSE_LAYER: OverlayLayer = {
  ...NO_LAYER,
  poses: [
    {
      t: "pose", score: 0.91, left: 0.3, top: 0.25, right: 0.6, bottom: 0.95,
      points: [[0.45, 0.3, 0.9], [0.45, 0.42, 0.9], [0.34, 0.55, 0.8], [0.57, 0.36, 0.8], [0.45, 0.65, 0.9], [0.4, 0.92, 0.7], [0.52, 0.92, 0.3]],
    },
  ],
};
const DEPTH = modelOf("depth");
const DEPTH_LAYER = mapOf((x, y) => (y < 0.05 ? 255 : Math.round(15 * Math.min(1, y * 0.7 + (Math.hypot(x - 0.3, y - 0.6) < 0.2 ? 0.4 : 0)))), { near: 0.84, far: 6.2 });

function renderModel(overlays: readonly PictureOverlay[], ground = "linear-gradient(#fff, #9aa, #000)"): TemplateResult {
  return html`<div ${styled({ position: "relative", "aspect-ratio": "4 / 3", background: ground })}>
    <t-model-overlay .overlays=${overlays}></t-model-overlay>
  </div>`;
}

function renderModels(models: readonly ModelRow[]): TemplateResult {
  return html`<div ${styled({ "min-block-size": "6rem", background: "#667" })}><t-models .models=${models}></t-models></div>`;
}

const FLOOR: readonly ModelRow["words"][number][] = [
  { text: "floor 38\u00a0%", colour: 2 },
  { text: "wall 17\u00a0%", colour: 3 },
  { text: "door 7\u00a0%", colour: 4 },
];

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-boxes",
    states: [
      { name: "on this picture", show: () => renderBoxed(THINGS) },
      { name: "of an earlier picture", show: () => renderBoxed(THINGS, true) },
      { name: "looked at closely", show: () => renderBoxed(THINGS, false, { scale: 2, x: -0.2, y: -0.8 }) },
      { name: "on white", show: () => renderBoxed(THINGS, false, undefined, "#fff") },
      { name: "nothing", show: () => renderBoxed([]) },
    ],
  },
  {
    tag: "t-picture-marks",
    states: [
      { name: "zone and line", show: () => renderMarked("linear-gradient(#fff, #9aa, #000)") },
      { name: "on white", show: () => renderMarked("#fff") },
    ],
  },
  {
    tag: "t-path-sketch",
    states: [{ name: "a path", show: () => html`<t-path-sketch .path=${STORY.path}></t-path-sketch>` }],
  },
  {
    tag: "t-objects",
    states: [
      { name: "off", show: () => renderObjects(false, "waiting", []) },
      { name: "waiting for the detector", show: () => renderObjects(true, "waiting", []) },
      { name: "nothing seen", show: () => renderObjects(true, "telling", []) },
      { name: "some seen", show: () => renderObjects(true, "telling", [{ label: "person", many: 2 }, { label: "dog", many: 1 }]) },
      { name: "the detector is silent", show: () => renderObjects(true, "silent", []) },
      { name: "while driving", show: () => renderObjects(true, "telling", [{ label: "person", many: 1 }], true) },
    ],
  },
  {
    tag: "t-model-overlay",
    states: [
      { name: "areas", show: () => renderModel([{ model: GROUND, layer: GROUND_LAYER, earlier: false }]) },
      { name: "areas of an earlier picture", show: () => renderModel([{ model: GROUND, layer: GROUND_LAYER, earlier: true }]) },
      { name: "areas on white", show: () => renderModel([{ model: GROUND, layer: GROUND_LAYER, earlier: false }], "#fff") },
      { name: "key points", show: () => renderModel([{ model: POSE, layer: POSE_LAYER, earlier: false }]) },
      { name: "key points of an earlier picture", show: () => renderModel([{ model: POSE, layer: POSE_LAYER, earlier: true }]) },
      { name: "depth", show: () => renderModel([{ model: DEPTH, layer: DEPTH_LAYER, earlier: false }], "#345") },
      { name: "nothing", show: () => renderModel([]) },
    ],
  },
  {
    tag: "t-models",
    states: [
      { name: "off", show: () => renderModels([{ id: "ground", on: false, state: "waiting", words: [] }]) },
      { name: "waiting for the model", show: () => renderModels([{ id: "ground", on: true, state: "waiting", words: [] }]) },
      { name: "areas", show: () => renderModels([{ id: "ground", on: true, state: "telling", words: FLOOR }]) },
      { name: "more classes than have room", show: () => renderModels([{ id: "ground", on: true, state: "telling", words: [...FLOOR, ...FLOOR, ...FLOOR] }]) },
      { name: "nothing of it", show: () => renderModels([{ id: "ground", on: true, state: "telling", words: [] }]) },
      { name: "the model is silent", show: () => renderModels([{ id: "ground", on: true, state: "silent", words: FLOOR }]) },
      {
        name: "several",
        show: () =>
          renderModels([
            { id: "ground", on: true, state: "telling", words: FLOOR },
            { id: "room", on: true, state: "telling", words: [{ text: "hall 93\u00a0%", colour: 0 }, { text: "kitchen 5\u00a0%", colour: 0 }] },
            { id: "pose", on: true, state: "telling", words: [{ text: "2\u00a0× person", colour: 0 }] },
            { id: "far", on: false, state: "waiting", words: [] },
          ]),
      },
    ],
  },
  {
    tag: "t-objects-choice",
    states: [
      { name: "as described", show: () => html`<t-objects-choice .classes=${CLASSES}></t-objects-choice>` },
      { name: "chosen", show: () => html`<t-objects-choice .classes=${CLASSES} .plain=${false} confidence="0.8"></t-objects-choice>` },
    ],
  },
  {
    tag: "t-sighting",
    wide: true,
    states: [
      { name: "over", show: () => renderSeen({}, PICTURE) },
      { name: "followed", show: () => renderSeen({ story: STORY }, PICTURE) },
      { name: "in sight", show: () => renderSeen({ many: 1, ended_us: null }, PICTURE) },
      { name: "without a picture", show: () => renderSeen({ label: "wine glass" }) },
      { name: "picture not kept", show: () => renderSeen({ label: "dog" }, "/missing.jpg") },
    ],
  },
];
