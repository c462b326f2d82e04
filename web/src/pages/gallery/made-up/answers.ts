/** What a hub that is made up for the gallery answers to questions, by what is the matter with it. */

import type { AlarmUpdate } from "../../../generated/wire.js";
import type { EventList, FrameList, GraphShape, HistoryAnswer, LogPageShape, MapOffer, SiteNightShape, TopicTable } from "../../../generated/api.js";
import { DETAIL, readingAt, SITE } from "./site.js";

/**
 * - `live`: all is well
 * - `empty`: nothing has come yet, and nothing is kept
 * - `stale`: what there is, is old
 * - `away`: the gateway is not connected
 * - `barred`: the person may see nothing of it
 * - `failing`: the hub cannot answer, and the devices are not reached
 */
export const MOODS = ["live", "empty", "stale", "away", "barred", "failing"] as const;
export type Mood = (typeof MOODS)[number];

/** Old values are so old (s). */
export const OLD_S = 95;
const HOUR_US = 3_600_000_000;
const nowUs = (): number => Date.now() * 1000;

export const LOG_LINES: readonly (readonly [level: number, node: string, text: string])[] = [
  [20, "controller_server", "Reached the goal"],
  [30, "lidar", "Scan is 140 ms late"],
  [40, "base", "Left wheel: over-current, switched off"],
  [20, "planner_server", "Planning to (1.5, 0.0)"],
  [20, "lifecycle_manager", "All nodes are active"],
];

const logPage = (): LogPageShape => ({
  lines: LOG_LINES.map(([level, node, text], at) => ({ id: String(100 - at), time_us: nowUs() - (at + 1) * 2_700_000, level, node, text, function: "", file: "", line: 0, left_out: 0 })),
  next: null,
});

const eventList = (): EventList => ({
  events: [
    ["command", "base", "Marta", "Wander about: accepted", true],
    ["stop", "base", "Marta", "STOP, confirmed by the robot after 38 ms", true],
    ["alarm_raised", "base", "", "Battery is low: 18 %", false],
  ].map(([kind, device, who, message, good], at) => ({ id: String(at), time_us: nowUs() - at * 95_000_000, kind: String(kind), device: String(device), who: String(who), message: String(message), good: good === true })),
  more: false,
});

const GRAPH: GraphShape = {
  online: true,
  nodes: [
    { name: "/lidar", publishes: ["/scan"], subscribes: [] },
    { name: "/slam_toolbox", publishes: ["/map"], subscribes: ["/scan", "/odom"] },
    { name: "/planner_server", publishes: ["/plan"], subscribes: ["/map"] },
    { name: "/base", publishes: ["/odom"], subscribes: ["/plan"] },
  ],
};

function nightState(): SiteNightShape {
  const begin = nowUs() - HOUR_US;
  const block = (target: string, proposal: string, from: number, to: number): SiteNightShape["plan"] extends infer P ? (P extends { blocks: readonly (infer B)[] } ? B : never) : never => ({
    request: target, proposal, target, start_us: begin + from * HOUR_US, end_us: begin + to * HOUR_US, overhead_s: 60, reason: "highest of those allowed", pauses: [],
  });
  return {
    online: true, simulated: false, time_lapse: "", state: null,
    plan: {
      made_us: nowUs() - 240e6, night_start_us: begin, night_end_us: begin + 9 * HOUR_US, method: "best first", value: 1, bound: null,
      blocks: [block("M 31", "survey", 1.2, 3), block("M 42", "school-1", 3.1, 5), block("RZ Cas", "variables", 5.2, 6)],
    },
  };
}

const NO_NIGHT: SiteNightShape = { online: true, simulated: false, time_lapse: "", state: null, plan: null };

const frameList = (): FrameList => ({
  frames: [
    {
      id: "m42", device: "imager", night: "2026-11-23", name: "m42.fits", time_us: nowUs() - 600e6, target: "M 42", filter: "R", kind: "light", exposure_s: 60, ra_deg: 83.8, dec_deg: -5.4,
      width: 640, height: 480, bytes: 614_400, digest: "", problems: [], measured: true, solved: true, stars: 214, fwhm: 2.4, background: 810, zero_point: null, note: "",
    },
  ],
  more: false,
});

const topicTable = (topics: readonly (readonly [string, string])[]): TopicTable => ({
  online: true,
  topics: topics.map(([topic, type]) => ({ topic, type, latched: false, max_rate: 0, problem: "", described: true, right: "view", device: "", rate: 5 })),
});

/** The trail of the last minutes; empty for a mood that has none. */
function historyOf(query: URLSearchParams, mood: Mood): HistoryAnswer {
  const late = mood === "live" ? 0 : OLD_S;
  const seconds = mood === "empty" ? [] : Array.from({ length: 120 }, (_, at) => Date.now() / 1000 - late - 240 + at * 2);
  return {
    series: query.getAll("channel").map((address) => ({
      address, kind: "exact", t_us: seconds.map((s) => Math.round(s * 1e6)), v: seconds.map((s) => { const value = readingAt(address, s); return typeof value === "number" ? value : null; }), gaps: [],
    })),
  };
}

const NO_MAPS: MapOffer = { files: [], sources: [] };

/** The answer to a path below the made-up site; null where it knows none. */
function bodyOf(path: string, query: URLSearchParams, mood: Mood): unknown {
  const filled = mood !== "empty";
  if (path === "/api/maps") return NO_MAPS;
  switch (path.slice(`/api/sites/${SITE}`.length)) {
    case "":
      return DETAIL;
    case "/log":
      return filled ? logPage() : { lines: [], next: null };
    case "/events":
      return filled ? eventList() : { events: [], more: false };
    case "/graph":
      return filled ? { ...GRAPH, online: mood !== "away" } : { online: true, nodes: [] };
    case "/night":
      return filled ? nightState() : NO_NIGHT;
    case "/frames":
      return filled ? frameList() : { frames: [], more: false };
    case "/topics":
      return topicTable(filled ? [["/odom", "nav_msgs/msg/Odometry"], ["/scan", "sensor_msgs/msg/LaserScan"]] : []);
    case "/history":
      return historyOf(query, mood);
    default:
      return null;
  }
}

function refuseWith(status: number, code: string, message: string): Response {
  return Response.json({ code, message }, { status });
}

/** A field of stars, as the archive draws a picture. */
async function drawStars(): Promise<Response> {
  const picture = new OffscreenCanvas(480, 360);
  const pen = picture.getContext("2d");
  if (pen !== null) {
    pen.fillStyle = "#12151a";
    pen.fillRect(0, 0, 480, 360);
    pen.fillStyle = "#e8ecf2";
    for (let at = 0; at < 90; at += 1) {
      pen.beginPath();
      pen.arc((at * 211) % 480, (at * 137) % 360, 0.6 + (at % 7) / 3, 0, 2 * Math.PI);
      pen.fill();
    }
  }
  return new Response(await picture.convertToBlob({ type: "image/png" }));
}

/** Stands in for `fetch`. */
export function answerAs(mood: Mood): typeof fetch {
  return (asked) => {
    const { pathname, searchParams } = new URL(asked instanceof Request ? asked.url : asked, location.origin);
    if (mood === "barred") return Promise.resolve(refuseWith(403, "forbidden", "Your role may not see this."));
    if (mood === "failing") return Promise.resolve(refuseWith(503, "store", "The hub's database cannot be reached."));
    if (pathname.endsWith("/preview")) return drawStars();
    const body = bodyOf(pathname, searchParams, mood);
    return Promise.resolve(body === null ? refuseWith(404, "unknown", `There is no ${pathname} in the gallery.`) : Response.json(body));
  };
}

/** Alarms as the hub tells them to a page that comes. */
export function alarmsOf(mood: Mood): readonly Partial<AlarmUpdate>[] {
  if (mood === "empty" || mood === "barred") return [];
  const alarm = { t: "alarm", site: SITE, device: "base", kind: "limit", known: mood === "live", unknown_why: mood === "live" ? "" : "its device is not reached", raised_us: nowUs() - 260e6 } as const;
  return [
    { ...alarm, alarm: "battery", name: "Battery is low", severity: "warning", phase: "active", why: "Battery is 18 %, below 20 %" },
    { ...alarm, alarm: "tilt", name: "Too steep", severity: "critical", phase: "normal", why: "" },
  ];
}
