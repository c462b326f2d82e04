/** A site that is made up for the gallery: a vehicle and an observatory, so that every tile has something to show. */

import type { ArgumentShape, CommandShape, DeviceShape, LimitShape, SignalShape, SiteShape, StreamShape, TileShape } from "../../../generated/api.js";

export const SITE = "yard";

function madeSignal(address: string, name: string, more: Partial<SignalShape> = {}): SignalShape {
  return {
    id: address.slice(address.indexOf("/") + 1), address, name, type: "number", role: "none", unit: "", decimals: -1, minimum: null, maximum: null, shown: null, states: [], meanings: [],
    frame: "", max_age: 5, primary: true, public: false, ros: "", channels: [address], ...more,
  };
}

function madeState(address: string, name: string, states: readonly string[], more: Partial<SignalShape> = {}): SignalShape {
  return madeSignal(address, name, { type: "state", states, ...more });
}

function madeArgument(id: string, name: string, more: Partial<ArgumentShape> = {}): ArgumentShape {
  return { id, name, type: "number", unit: "", minimum: null, maximum: null, max_length: 200, default: null, ...more };
}

function madeCommand(id: string, name: string, more: Partial<CommandShape> = {}): CommandShape {
  return { id, name, role: "none", description: "", confirm: false, timeout: 10, cancellable: false, needs: null, ros: "", arguments: [], ...more };
}

function madeDevice(id: string, name: string, kind: DeviceShape["kind"], more: Partial<DeviceShape> = {}): DeviceShape {
  return {
    id, name, kind, signals: [], streams: [], commands: [], drive: null, public: false, link_loss: "", pointing: null, slew: null, unguarded: false, rights: ["view", "use", "admin"], ...more,
  };
}

function madeStream(address: string, name: string): StreamShape {
  return { id: address.slice(address.indexOf("/") + 1), address, name, max_rate: 15, public: false, detect: null, lane: null, models: [] };
}

const BASE = madeDevice("base", "Vehicle base", "vehicle", {
  signals: [
    madeSignal("base/speed", "Speed", { unit: "m/s", decimals: 2, role: "vehicle.speed", minimum: -0.5, maximum: 0.5 }),
    madeSignal("base/turn", "Turn rate", { unit: "rad/s", decimals: 2, role: "vehicle.turn_rate", minimum: -2, maximum: 2 }),
    madeSignal("base/battery", "Battery", { unit: "%", decimals: 0, role: "battery.level", minimum: 0, maximum: 100 }),
    madeState("base/mode", "Mode", ["docked", "driving", "waiting"]),
    madeSignal("base/note", "Last word", { type: "text" }),
    madeSignal("base/pose", "Position", { type: "position", frame: "local", unit: "m", role: "vehicle.position", channels: ["base/pose.x", "base/pose.y", "base/pose.yaw"] }),
  ],
  streams: [madeStream("base/front", "Front camera"), madeStream("base/rear", "Rear camera")],
  commands: [
    madeCommand("wander", "Wander about", { description: "It drives about by itself.", cancellable: true, timeout: 120, arguments: [madeArgument("minutes", "For", { unit: "min", minimum: 1, maximum: 30, default: 5 }), madeArgument("shy", "Away from people", { type: "boolean", default: true })] }),
  ],
  drive: {
    max_speed: 0.5, max_reverse: 0.3, max_sideways: 0, max_turn: 2, max_steering: 0, joints: [], ptz: false, rate: 20, ttl: 0.25, lease: 3, picture: "base/front", position: "base/pose", stop: true,
    shown_speed: null, shown_turn: null,
  },
});

const LIDAR = madeDevice("lidar", "Lidar", "other", {
  signals: [
    madeSignal("lidar/limit", "Greatest range", { unit: "m", decimals: 1, ros: "parameter" }),
    madeState("lidar/state", "State", ["inactive", "active"], { ros: "lifecycle" }),
  ],
  commands: [
    madeCommand("set_limit", "Set the range", { ros: "parameter", arguments: [madeArgument("value", "Range", { unit: "m", minimum: 1, maximum: 12, default: 8 })] }),
    madeCommand("activate", "Activate", { ros: "lifecycle", needs: { channel: "lidar/state", max_age: 5, states: ["inactive", "active"], among: ["inactive"] } }),
    madeCommand("deactivate", "Deactivate", { ros: "lifecycle", needs: { channel: "lidar/state", max_age: 5, states: ["inactive", "active"], among: ["active"] } }),
  ],
});

const DOME = madeDevice("dome", "Dome", "dome", {
  signals: [
    madeState("dome/shutter", "Shutter", ["closed", "open", "opening", "closing"], { role: "dome.shutter", meanings: ["closed", "open", "opening", "closing"] }),
    madeSignal("dome/azimuth", "Azimuth", { unit: "°", decimals: 1, role: "dome.azimuth", minimum: 0, maximum: 360 }),
  ],
  commands: [
    madeCommand("open", "Open", { role: "dome.open", confirm: true }),
    madeCommand("close", "Close", { role: "dome.close" }),
    madeCommand("halt", "Stop", { role: "dome.stop" }),
    madeCommand("turn", "Turn to", { role: "dome.goto", arguments: [madeArgument("azimuth", "Azimuth", { unit: "°", minimum: 0, maximum: 360 })] }),
  ],
});

const TELESCOPE = madeDevice("telescope", "Telescope", "telescope", {
  signals: [
    madeState("telescope/state", "State", ["parked", "tracking", "slewing"], { role: "telescope.state" }),
    madeSignal("telescope/ra", "Right ascension", { unit: "h", role: "telescope.ra" }),
    madeSignal("telescope/dec", "Declination", { unit: "°", role: "telescope.dec" }),
    madeSignal("telescope/alt", "Altitude", { unit: "°", role: "telescope.altitude" }),
    madeSignal("telescope/az", "Azimuth", { unit: "°", role: "telescope.azimuth" }),
  ],
  commands: [madeCommand("park", "Park", { role: "telescope.park" }), madeCommand("halt", "Stop", { role: "telescope.stop" })],
});

const WEATHER = madeDevice("weather", "Weather station", "weather", {
  signals: [
    madeSignal("weather/wind", "Wind", { unit: "m/s", decimals: 1, role: "weather.wind" }),
    madeSignal("weather/humidity", "Humidity", { unit: "%", decimals: 0, role: "weather.humidity" }),
    madeSignal("weather/temperature", "Temperature", { unit: "°C", decimals: 1, role: "weather.temperature" }),
    madeState("weather/rain", "Rain", ["dry", "rain"], { role: "weather.raining" }),
  ],
});

const CAMERA = madeDevice("imager", "Main camera", "camera", {
  signals: [
    madeState("imager/state", "State", ["idle", "exposing", "reading"], { role: "camera.state", meanings: ["idle", "exposing", "reading"] }),
    madeSignal("imager/temperature", "Chip", { unit: "°C", decimals: 1, role: "camera.temperature" }),
  ],
  commands: [madeCommand("expose", "Expose", { role: "camera.expose", arguments: [madeArgument("seconds", "Exposure", { unit: "s", minimum: 0, maximum: 3600, default: 60 })] }), madeCommand("abort", "Abort", { role: "camera.abort" })],
});

const POWER = madeDevice("power", "Power", "power", {
  signals: [
    madeState("power/mount", "Mount", ["off", "on"], { role: "power.outlet" }),
    madeSignal("power/voltage", "Voltage", { unit: "V", decimals: 1, role: "power.voltage" }),
  ],
  commands: [madeCommand("mount_on", "Mount on", { role: "power.on" }), madeCommand("mount_off", "Mount off", { role: "power.off" })],
});

function madeLimit(signal: string, more: Partial<LimitShape>): LimitShape {
  return { signal, minus: "", humidity: "", above: null, until_below: null, below: null, until_above: null, states: [], safe_states: [], ...more };
}

/** Who sees all of it. */
export const DETAIL: SiteShape = {
  site: SITE, name: "Yard", zone: "Europe/Madrid", online: true, since_us: 0, last_seen_us: 0, catalogue: "c1",
  place: { latitude: 42.0517, longitude: 0.7297, elevation: 800 },
  devices: [BASE, LIDAR, DOME, TELESCOPE, WEATHER, CAMERA, POWER],
  rules: [
    {
      id: "weather", name: "Bad weather", hidden: 0, targets: ["dome/open"], dwell: 300,
      conditions: [
        { limits: [madeLimit("weather/wind", { above: 12, until_below: 10 })], lasting: 0, link_lost: null, sun: "" },
        { limits: [madeLimit("weather/rain", { safe_states: ["dry"] })], lasting: 0, link_lost: null, sun: "" },
      ],
    },
  ],
  enclosures: [], shown_units: {}, map: null,
};

export const EXTENSIONS: readonly TileShape[] = [
  { name: "wheel", title: "Wheel", module: "/gallery-tile.js", device: "vehicle", signals: [{ name: "speed", type: "", unit: "", id: "", role: "vehicle.speed" }] },
  { name: "broken", title: "Broken tile", module: "/no-such-tile.js", device: "vehicle", signals: [] },
];

const WORDS = ["Door 3 is passed", "Stairs ahead: it turned back", "On its way to the dock"] as const;
const wave = (seconds: number, length: number): number => Math.sin((2 * Math.PI * seconds) / length);

/** What each channel reads at a time (s), and a text where it holds one. */
const CHANNELS: Readonly<Record<string, (seconds: number) => number | string>> = {
  "base/speed": (s) => 0.2 + 0.18 * wave(s, 40),
  "base/turn": (s) => 1.1 * wave(s, 25),
  "base/battery": (s) => 71 + 12 * wave(s, 600),
  "base/mode": (s) => Math.floor(s / 30) % 3,
  "base/note": (s) => WORDS[Math.floor(s / 20) % WORDS.length] ?? "",
  "base/pose.x": (s) => 3 * wave(s, 90),
  "base/pose.y": (s) => 1.6 * wave(s, 45),
  "base/pose.yaw": (s) => wave(s, 30),
  "lidar/limit": () => 8,
  "lidar/state": () => 1,
  "dome/shutter": () => 1,
  "dome/azimuth": () => 215,
  "telescope/state": () => 1,
  "telescope/ra": () => 5.588,
  "telescope/dec": () => -5.39,
  "telescope/alt": () => 41,
  "telescope/az": () => 152,
  "weather/wind": (s) => 4.2 + wave(s, 20),
  "weather/humidity": () => 58,
  "weather/temperature": () => 9.4,
  "weather/rain": () => 0,
  "imager/state": () => 1,
  "imager/temperature": () => -10,
  "power/mount": () => 1,
  "power/voltage": () => 12.6,
};

export function readingAt(channel: string, seconds: number): number | string | null {
  return CHANNELS[channel]?.(seconds) ?? null;
}
