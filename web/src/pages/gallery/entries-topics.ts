/** Raw topics: messages as trees, diagnostics, and what keeps a topic from being seen. */

import { html, type TemplateResult } from "lit";
import type { TopicState } from "../../controllers/topic-follower.js";
import "../../elements/topic/diagnostics-tree.js";
import "../../elements/topic/field-plot.js";
import "../../elements/topic/message-tree.js";
import { renderTopicStatus, renderTopicTrouble } from "../../elements/topic/topic-state.js";
import "../../elements/topic/node-graph.js";
import type { GraphNodeShape } from "../../generated/api.js";
import { DiagnosticsBook, type DiagnosticNode } from "../../series/diagnostics.js";
import type { FieldTrace } from "../../topics/field-traces.js";
import { PastBoard } from "../../state/past/past-board.js";
import type { PastTopicSource } from "../../state/past/past-topics.js";
import "../../elements/topic/unrecorded.js";
import type { GalleryEntry, GalleryState } from "./entry.js";

const MESSAGE = {
  header: { stamp: { sec: 1_780_000_000, nanosec: 500_000_000 }, frame_id: "laser" },
  angle_min: -1.5707963,
  ranges: { $first: [2.31, 2.33, { $number: "Infinity" }, 2.4], $of: 360 },
  shelves: [
    { number: 1, celsius: -1 },
    { number: 2, celsius: 187.5 },
  ],
  note: { $text: "a long text that goes on", $of: 40_000 },
};

const WAVE = Array.from({ length: 100 }, (_, at) => at * 600);
const TRACES: readonly FieldTrace[] = [
  { path: "twist.linear.x", points: WAVE.map((atMs) => ({ atMs, value: Math.sin(atMs / 7000) })) },
  { path: "twist.angular.z", points: WAVE.map((atMs) => ({ atMs, value: 0.4 * Math.cos(atMs / 4000) })) },
];

const status = (name: string, level: number, message: string, values: Readonly<Record<string, string>> = {}): object => ({
  name, level, message, hardware_id: "board 7", values: Object.entries(values).map(([key, value]) => ({ key, value })),
});
const GOOD = [status("/Robot/Arm/elbow", 0, "in order", { temperature: "41 °C" }), status("lidar: rate", 0, "9.98 Hz")];
const BAD = [status("/Robot/Arm/wrist", 2, "over-current, switched off", { current: "7.4 A", limit: "5 A" }), status("/Robot/Battery", 1, "18 % left")];

function bookAt(statuses: readonly object[], laterMs: number): DiagnosticNode {
  const book = new DiagnosticsBook();
  book.addMessage({ status: statuses }, 0);
  return book.treeAt(laterMs);
}

function renderDiagnostics(statuses: readonly object[], laterMs = 500, left = 0): TemplateResult {
  return html`<t-diagnostics .root=${bookAt(statuses, laterMs)} .left=${left}></t-diagnostics>`;
}

const STATES: readonly (readonly [state: TopicState, age: number | null, why: string])[] = [
  ["loading", null, ""],
  ["waiting", null, ""],
  ["live", 0.2, ""],
  ["stale", 83, ""],
  ["ended", 12, ""],
  ["away", 40, ""],
  ["away", null, ""],
  ["lost", 9, ""],
  ["lost", null, ""],
  ["error", 1, "the type oven_own_msgs/msg/Bake: none of its definitions has the hash that its publisher tells"],
  ["forbidden", null, "you have no right to this topic any more"],
];

const MOMENT_US = Date.UTC(2026, 2, 29, 21, 15) * 1000;
const NO_SAMPLES = { history: () => Promise.resolve({ series: [] }), lastValues: () => Promise.resolve({ values: [] }) };

/** A moment that lies so many seconds behind one recording and before another. */
function pastBetween(earlierS: number | null, laterS: number | null, problems: readonly string[] = []): PastBoard {
  const at = (byS: number | null): number | null => (byS === null ? null : MOMENT_US + byS * 1e6);
  const source: PastTopicSource = {
    moment: () => Promise.resolve({ topics: [], earlier_us: at(earlierS), later_us: at(laterS), problems }),
    trees: (_site, _wishes, _fromUs, untilUs) => Promise.resolve({ topics: [], messages: [], untilUs }),
    bytes: (_site, _wishes, _points, _fromUs, untilUs) => Promise.resolve({ topics: [], messages: [], untilUs }),
  };
  return new PastBoard("gallery", NO_SAMPLES, MOMENT_US, undefined, source);
}

const WHAT = "/scan is in no recording of this moment.";

const ROBOT: readonly GraphNodeShape[] = [
  { name: "/lidar", publishes: ["/scan"], subscribes: [] },
  { name: "/slam_toolbox", publishes: ["/map", "/tf"], subscribes: ["/scan", "/odom"] },
  { name: "/planner_server", publishes: ["/plan"], subscribes: ["/map", "/tf"] },
  { name: "/controller_server", publishes: ["/cmd_vel"], subscribes: ["/plan", "/scan", "/odom", "/tf"] },
  { name: "/base", publishes: ["/odom", "/tf", "/joint_states"], subscribes: ["/cmd_vel"] },
  { name: "/robot_state_publisher", publishes: ["/tf_static", "/robot_description"], subscribes: ["/joint_states"] },
];
const MANY: readonly GraphNodeShape[] = Array.from({ length: 300 }, (_, at) => ({ name: `/swarm/robot_${String(at)}/controller`, publishes: [`/swarm/robot_${String(at)}/state`], subscribes: [`/swarm/robot_${String((at + 1) % 300)}/state`] }));

export const entries: readonly GalleryEntry[] = [
  {
    tag: "t-node-graph",
    wide: true,
    states: [
      { name: "a robot", show: () => html`<t-node-graph .nodes=${ROBOT}></t-node-graph>` },
      { name: "around a node", show: () => html`<t-node-graph .nodes=${ROBOT} around="/slam_toolbox"></t-node-graph>` },
      { name: "hundreds of nodes", show: () => html`<t-node-graph .nodes=${MANY}></t-node-graph>` },
    ],
  },
  {
    tag: "t-unrecorded",
    states: [
      { name: "between two recordings", show: () => html`<t-unrecorded .past=${pastBetween(-90, 600)} what=${WHAT}></t-unrecorded>` },
      { name: "after the last one", show: () => html`<t-unrecorded .past=${pastBetween(-90, null)} what=${WHAT}></t-unrecorded>` },
      { name: "none at all", show: () => html`<t-unrecorded .past=${pastBetween(null, null)} what=${WHAT}></t-unrecorded>` },
      { name: "a file that cannot be read", show: () => html`<t-unrecorded .past=${pastBetween(-90, null, ["20260329T211400Z-ab12cd: it has no index; \`mcap recover\` makes one"])} what=${WHAT}></t-unrecorded>` },
    ],
  },
  {
    tag: "t-message-tree",
    wide: true,
    states: [
      { name: "a message", show: () => html`<t-message-tree .value=${MESSAGE}></t-message-tree>` },
      { name: "searched", show: () => html`<t-message-tree .value=${MESSAGE} search="[1].celsius"></t-message-tree>` },
      { name: "searched in vain", show: () => html`<t-message-tree .value=${MESSAGE} search="velocity"></t-message-tree>` },
      { name: "with fields to plot", show: () => html`<t-message-tree .value=${MESSAGE} .plotted=${["angle_min"]}></t-message-tree>` },
      { name: "with fields to make signals of", show: () => html`<t-message-tree .value=${MESSAGE} .plotted=${[]} signals></t-message-tree>` },
      { name: "of std_msgs/Empty", show: () => html`<t-message-tree .value=${{}}></t-message-tree>` },
    ],
  },
  {
    tag: "t-field-plot",
    wide: true,
    states: [
      { name: "two fields", show: () => html`<t-field-plot .traces=${TRACES} .nowMs=${60_000}></t-field-plot>` },
      { name: "before the first number", show: () => html`<t-field-plot .traces=${[{ path: "twist.linear.x", points: [] }]}></t-field-plot>` },
    ],
  },
  {
    tag: "t-diagnostics",
    wide: true,
    states: [
      { name: "in order", show: () => renderDiagnostics(GOOD) },
      { name: "in trouble", show: () => renderDiagnostics([...GOOD, ...BAD]) },
      { name: "stale", show: () => renderDiagnostics([...GOOD, ...BAD], 60_000) },
      { name: "too many to be shown", show: () => renderDiagnostics(GOOD, 500, 312) },
      { name: "empty", show: () => renderDiagnostics([]) },
    ],
  },
  {
    tag: "t-topic",
    wide: true,
    states: STATES.map(
      ([state, age, why]): GalleryState => ({
        name: age === null ? state : `${state}, ${String(age)} s after a message`,
        show: () => html`<p>${renderTopicStatus({ topic: "/scan", state, age, why })}</p>${renderTopicTrouble({ topic: "/scan", state, age, why })}`,
      }),
    ),
  },
];
