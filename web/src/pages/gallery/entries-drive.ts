/** The actuate page's elements in each of their states. */

import { html, type TemplateResult } from "lit";
import { ref } from "lit/directives/ref.js";
import { padStick } from "../../controllers/drive/stick.js";
import { CameraView, type CameraLink } from "../../elements/camera/camera-view.js";
import "../../elements/command/command-form.js";
import type { CommandRequestState } from "../../elements/command/command-form.js";
import "../../elements/drive/arrow-pad.js";
import "../../elements/drive/drive-readout.js";
import "../../elements/drive/lease-line.js";
import "../../elements/drive/touch-pad.js";
import "../../elements/drive/speed-limit.js";
import "../../elements/command/interlock.js";
import "../../elements/map/track-map.js";
import type { TrackPoint } from "../../elements/map/track.js";
import "../../elements/stop/stop-button.js";
import "../../elements/stop/stop-state.js";
import type { HeldStop, StopPhase } from "../../elements/stop/stop-labels.js";
import type { InterlockUpdate } from "../../generated/wire.js";
import type { ArgumentShape, CommandShape } from "../../generated/api.js";
import type { GalleryEntry, GalleryState } from "./entry.js";

const NOON_US = 1_780_000_000_000_000;

/** A made-up picture, drawn once the element stands. */
function renderCamera(link: CameraLink, age: number, why = ""): TemplateResult {
  const picture = new OffscreenCanvas(640, 480);
  const pen = picture.getContext("2d");
  if (pen) {
    pen.fillStyle = "#b9c4c8";
    pen.fillRect(0, 0, 640, 480);
    pen.fillStyle = "#8a6f55";
    pen.beginPath();
    pen.moveTo(0, 480);
    pen.lineTo(640, 480);
    pen.lineTo(390, 250);
    pen.lineTo(250, 250);
    pen.fill();
    pen.fillStyle = "#2c6e49";
    pen.fillRect(430, 190, 70, 130);
  }
  const bitmap = picture.transferToImageBitmap();
  const show = async (element?: Element): Promise<void> => {
    if (!(element instanceof CameraView)) return;
    await element.updateComplete;
    element.drawPicture(bitmap);
  };
  return html`<t-camera-view
    name="Front camera"
    drawn
    .link=${link}
    .age=${age}
    .why=${why}
    .rate=${28}
    ${ref((element) => void show(element))}
  ></t-camera-view>`;
}

const TRAIL: readonly TrackPoint[] = Array.from({ length: 240 }, (_, i) => ({
  x: 2.2 * Math.sin(i / 40) + i / 160,
  y: 1.4 * Math.sin(i / 21),
  timeUs: i * 1e5,
}));
const HERE = { x: TRAIL[239]?.x ?? 0, y: TRAIL[239]?.y ?? 0, yaw: 0.9 };

function argument(more: Partial<ArgumentShape> & Pick<ArgumentShape, "id" | "name" | "type">): ArgumentShape {
  return { unit: "", minimum: null, maximum: null, max_length: 200, default: null, ...more };
}

const LOCK: InterlockUpdate = {
  t: "interlock_news",
  site: "observatory",
  interlock: "weather",
  name: "Bad weather",
  locked: true,
  unsafe: true,
  why: "Wind is above 12 m/s",
  since_us: NOON_US,
  clears_ms: 0,
  refuses: ["Dome: Open", "Telescope: Slew"], targets: [], slows: [], slowed: [], overridable: true,
  overridden_by: "",
  reason: "",
  override_ms: 0,
  longest_s: 1800,
  condition: "weather/wind",
  no_override: "",
  unknown: [],
};
const WAITING: InterlockUpdate = {
  ...LOCK,
  unsafe: false,
  longest_s: 0,
  overridable: false,
  no_override: "Rain: rain is never overridden",
};
const OVERRIDDEN: InterlockUpdate = { ...LOCK, overridden_by: "Grace", reason: "Testing the shutter" };

const WANDER: CommandShape = {
  id: "wander",
  name: "Wander about",
  description: "The vehicle drives about by itself and avoids what its lidar sees.",
  role: "none",
  confirm: false,
  timeout: 10,
  cancellable: false,
  needs: null,
  ros: "",
  arguments: [argument({ id: "active", name: "Active", type: "boolean", default: true })],
};
const SLEW: CommandShape = {
  id: "slew",
  name: "Slew the telescope",
  description: "It moves at once and fast. Nobody may stand beside it.",
  role: "none",
  confirm: true,
  timeout: 60,
  cancellable: true,
  needs: null,
  ros: "",
  arguments: [
    argument({ id: "az", name: "Azimuth", type: "number", unit: "°", minimum: 0, maximum: 360, default: 180 }),
    argument({ id: "alt", name: "Altitude", type: "number", unit: "°", minimum: 10, maximum: 90 }),
    argument({ id: "note", name: "Note", type: "text" }),
  ],
};

function asked(phase: CommandRequestState["phase"], message = "", progress = 0): GalleryState {
  return {
    name: phase,
    show: () => html`<t-command .command=${WANDER} .asked=${{ phase, message, progress }}></t-command>`,
  };
}

function stopped(phase: StopPhase, name: string = phase): GalleryState {
  return {
    name,
    show: () => html`<t-stop-state .phase=${phase} who="Ada" .time=${NOON_US} zone="Europe/Madrid" .answered=${9}></t-stop-state>`,
  };
}

function heldStop(name: string, held: HeldStop): GalleryState {
  return { name, show: () => html`<t-stop-state phase="confirmed" who="Ada" .time=${NOON_US} .held=${held}></t-stop-state>` };
}

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-camera-view",
    states: [
      { name: "live", show: () => renderCamera("open", 84) },
      { name: "frozen", show: () => renderCamera("open", 2310) },
      { name: "age unknown", show: () => renderCamera("open", Number.NaN) },
      { name: "link lost", show: () => renderCamera("connecting", 5400, "The picture's connection is lost; trying again.") },
      { name: "connecting", show: () => html`<t-camera-view></t-camera-view>` },
      { name: "no picture yet", show: () => html`<t-camera-view link="open"></t-camera-view>` },
      { name: "bad pictures", show: () => html`<t-camera-view link="bad" why="/images: field 'encoding': 'yuv9' is not one of: rgb8, bgr8, …"></t-camera-view>` },
      { name: "no camera", show: () => html`<t-camera-view link="none"></t-camera-view>` },
      { name: "offline", show: () => html`<t-camera-view link="offline"></t-camera-view>` },
      { name: "forbidden", show: () => html`<t-camera-view link="refused" why="You need the right to view this device."></t-camera-view>` },
      { name: "unsupported", show: () => html`<t-camera-view link="unsupported" why="It comes as hevc; this page can show jpeg, png, webp."></t-camera-view>` },
    ],
  },
  {
    tag: "t-stop-button",
    wide: true,
    states: [
      { name: "clear", show: () => html`<t-stop-button .stop=${{ phase: "clear" }}></t-stop-button>` },
      { name: "unknown", show: () => html`<t-stop-button></t-stop-button>` },
      { name: "sent", show: () => html`<t-stop-button .stop=${{ phase: "sent", waiting: 80 }}></t-stop-button>` },
      { name: "no answer", show: () => html`<t-stop-button .stop=${{ phase: "sent", waiting: 2400 }}></t-stop-button>` },
      { name: "latched", show: () => html`<t-stop-button .stop=${{ phase: "latched" }}></t-stop-button>` },
      { name: "confirmed", show: () => html`<t-stop-button .stop=${{ phase: "confirmed" }}></t-stop-button>` },
      { name: "offline", show: () => html`<t-stop-button .stop=${{ phase: "unknown" }} .online=${false}></t-stop-button>` },
    ],
  },
  {
    tag: "t-stop-state",
    wide: true,
    states: [
      stopped("clear"),
      stopped("sent"),
      stopped("latched"),
      stopped("confirmed"),
      {
        name: "without the lease",
        show: () => html`<t-stop-state phase="confirmed" who="Grace" .time=${NOON_US} hindrance="Take control first: the person who releases STOP is responsible for what moves next."></t-stop-state>`,
      },
      { name: "second step", show: () => html`<t-stop-state phase="confirmed" who="Ada" .time=${NOON_US} step="armed" .armed=${6400}></t-stop-state>` },
      { name: "refused", show: () => html`<t-stop-state phase="latched" who="Ada" .time=${NOON_US} trouble="That key is not the newest."></t-stop-state>` },
      heldStop("second gateway silent", { held: 1, latched: 0, confirmed: 0 }),
      heldStop("second gateway latched", { held: 1, latched: 1, confirmed: 0 }),
      heldStop("second gateway confirmed", { held: 1, latched: 1, confirmed: 1 }),
      { name: "offline", show: () => html`<t-stop-state phase="sent" .online=${false}></t-stop-state>` },
    ],
  },
  {
    tag: "t-interlock",
    wide: true,
    states: [
      { name: "unsafe", show: () => html`<t-interlock .news=${LOCK} zone="UTC"></t-interlock>` },
      {
        name: "safe again, waiting",
        show: () => html`<t-interlock .news=${WAITING} .clears=${192_000}></t-interlock>`,
      },
      {
        name: "overridden",
        show: () => html`<t-interlock .news=${OVERRIDDEN} .override_=${540_000} site="Observatory"></t-interlock>`,
      },
    ],
  },
  {
    tag: "t-lease",
    wide: true,
    states: [
      { name: "free", show: () => html`<t-lease kind="free"></t-lease>` },
      { name: "asking", show: () => html`<t-lease kind="asking"></t-lease>` },
      { name: "mine", show: () => html`<t-lease kind="mine" .remains=${2400}></t-lease>` },
      { name: "mine, STOP on", show: () => html`<t-lease kind="mine" .remains=${2400} stopped></t-lease>` },
      {
        name: "asked for",
        show: () => html`<t-lease kind="mine" rival="Grace" .answer=${4200} .remains=${2400}></t-lease>`,
      },
      { name: "waiting", show: () => html`<t-lease kind="waiting" holder="Grace" .answer=${4200}></t-lease>` },
      { name: "may be forced", show: () => html`<t-lease kind="other" holder="Grace" forceable></t-lease>` },
      { name: "somebody else's", show: () => html`<t-lease kind="other" holder="Grace"></t-lease>` },
      { name: "offline", show: () => html`<t-lease kind="unknown" .online=${false}></t-lease>` },
    ],
  },
  {
    tag: "t-pad",
    states: [
      { name: "ready", show: () => html`<t-pad .stickOf=${padStick}></t-pad>` },
      { name: "disabled", show: () => html`<t-pad disabled></t-pad>` },
    ],
  },
  {
    tag: "t-arrows",
    states: [
      { name: "ready", show: () => html`<t-arrows></t-arrows>` },
      { name: "disabled", show: () => html`<t-arrows disabled></t-arrows>` },
    ],
  },
  {
    tag: "t-speed-limit",
    states: [
      { name: "half", show: () => html`<t-speed-limit .level=${0.5} .speed=${0.22} .turn=${2.84}></t-speed-limit>` },
      { name: "lowest", show: () => html`<t-speed-limit .level=${0.1} .speed=${0.22} .turn=${2.84}></t-speed-limit>` },
      { name: "disabled", show: () => html`<t-speed-limit disabled .speed=${0.22} .turn=${2.84}></t-speed-limit>` },
    ],
  },
  {
    tag: "t-drive-readout",
    states: [
      { name: "nothing known", show: () => html`<t-drive-readout></t-drive-readout>` },
      {
        name: "driven by characters",
        show: () => html`<t-drive-readout
          .asked=${{ linear: 0.5, angular: 0 }}
          .told=${{ linear: 0.3, angular: 0 }}
          .measured=${{ linear: 0.28, angular: 0 }}
          sent="w × 3"
        ></t-drive-readout>`,
      },
      {
        name: "driving",
        show: () => html`<t-drive-readout
          .asked=${{ linear: 0.11, angular: -0.57 }}
          .told=${{ linear: 0.11, angular: -0.57 }}
          .measured=${{ linear: 0.106, angular: -0.552 }}
        ></t-drive-readout>`,
      },
      {
        name: "capped",
        show: () => html`<t-drive-readout
          .asked=${{ linear: 0.22, angular: 0 }}
          .told=${{ linear: 0.11, angular: 0 }}
          .measured=${{ linear: 0.109, angular: 0.01 }}
          cap="Speed capped to 50 %: the link is slow."
        ></t-drive-readout>`,
      },
      {
        name: "refused",
        show: () => html`<t-drive-readout .asked=${{ linear: 0.22, angular: 0 }} .told=${{ linear: 0, angular: 0 }} refusal="the frame is too old"></t-drive-readout>`,
      },
    ],
  },
  {
    tag: "t-track-map",
    wide: true,
    states: [
      { name: "with trail", show: () => html`<t-track-map .trail=${TRAIL} .pose=${HERE} where="x 1.49 m, y −1.30 m, heading 52°"></t-track-map>` },
      { name: "stale", show: () => html`<t-track-map .trail=${TRAIL} .pose=${HERE} where="x 1.49 m, y −1.30 m" stale="Stale: from 12 s ago"></t-track-map>` },
      { name: "no heading", show: () => html`<t-track-map .pose=${{ x: 0, y: 0, yaw: Number.NaN }} where="41.387412°, 2.168634° (WGS 84)"></t-track-map>` },
      { name: "nothing yet", show: () => html`<t-track-map></t-track-map>` },
    ],
  },
  {
    tag: "t-command",
    wide: true,
    states: [
      { name: "switch", show: () => html`<t-command .command=${WANDER}></t-command>` },
      { name: "numbers, text, asks once more", show: () => html`<t-command .command=${SLEW}></t-command>` },
      asked("sent"),
      asked("accepted"),
      asked("running", "turning on the wander mode", 0.5),
      asked("succeeded", "Wander mode is on."),
      asked("failed", "The motors report over-temperature."),
      asked("refused", "STOP is on."),
      asked("cancelled", "Another command took its place."),
      asked("unknown", "No answer. It may or may not have been done: look at the device before you ask again."),
      asked("offline", "Not connected. Nothing was sent."),
      { name: "not allowed", show: () => html`<t-command .command=${WANDER} .allowed=${false}></t-command>` },
      {
        name: "locked by an interlock",
        show: () => html`<t-command
          .command=${WANDER}
          .locked=${"Locked by Bad weather: Wind is above 12 m/s. An admin can override it."}
        ></t-command>`,
      },
    ],
  },
];
