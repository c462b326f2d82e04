/** An alert rule as it is typed: read field by field, and made from one that is there. Pure. */

import { msg, str } from "@lit/localize";
import type { AlertFilterShape, AlertRuleAsk, AlertRuleShape, GroupShape, RequestShape } from "../../generated/api.js";
import { eitherText } from "../../words/lists.js";
import { FieldReader } from "../requests/form/field-reader.js";
import type { ReadGroup } from "../requests/form/read-draft.js";

export const ROLES = ["observation", "prediction", "utility", "test"] as const satisfies readonly NonNullable<AlertFilterShape["roles"]>[number][];
export type NoticeRole = (typeof ROLES)[number];

export type RuleField = "name" | "sources" | "roles" | "largestError" | "lowestDec" | "highestDec" | "parameters" | "hours" | "priority";

/** What is typed beside frames and constraints. */
export interface RuleDraft {
  readonly name: string;
  /** Patterns, one a line. */
  readonly sources: string;
  readonly roles: readonly NoticeRole[];
  readonly largestError: string;
  readonly lowestDec: string;
  readonly highestDec: string;
  /** Conditions, one a line: `Rate_Signif >= 7`. */
  readonly parameters: string;
  readonly hours: string;
  readonly priority: string;
  readonly active: boolean;
}

export const NEW_RULE: RuleDraft = {
  name: "", sources: "", roles: ["observation"], largestError: "", lowestDec: "", highestDec: "", parameters: "", hours: "24", priority: "10", active: true,
};

export interface ReadRule {
  /** Null while anything is wrong, also in frames or constraints. */
  readonly asked: AlertRuleAsk | null;
  readonly problems: ReadonlyMap<RuleField, string>;
}

export function readRule(draft: RuleDraft, request: ReadGroup["requests"][number] | undefined): ReadRule {
  const fields = new FieldReader<RuleField>();
  const name = draft.name.trim();
  if (name === "") fields.problems.set("name", msg("Give it a name: requests are called by it."));
  if (draft.roles.length === 0) fields.problems.set("roles", msg("Choose at least one: a notice always has a role."));
  const low = fields.optional("lowestDec", draft.lowestDec, [-90, 90], msg("Declination in °"), -90);
  const high = fields.optional("highestDec", draft.highestDec, [-90, 90], msg("Declination in °"), 90);
  if (low > high) fields.problems.set("highestDec", msg("It is lower than the lowest declination."));
  const filter: AlertFilterShape = {
    sources: linesOf(draft.sources),
    roles: draft.roles,
    largest_error: fields.optional("largestError", draft.largestError, [0, 180], msg("Error in °"), 0),
    lowest_declination: low,
    highest_declination: high,
    ...readParameters(draft.parameters, fields),
  };
  const hours = fields.number("hours", draft.hours, [0.01, 8784], msg("Hours after the event"));
  const priority = fields.number("priority", draft.priority, [0.001, 1000], msg("Priority"));
  // Only frames and constraints of the request count: the notice has the target, the rule the window.
  const isWhole = fields.problems.size === 0 && request?.problems.size === 0;
  if (!isWhole) return { asked: null, problems: fields.problems };
  const { configurations, constraints } = request.asked;
  return { asked: { name, filter, configurations, ...(constraints === undefined ? {} : { constraints }), hours, priority, active: draft.active }, problems: fields.problems };
}

function linesOf(text: string): readonly string[] {
  return text.split("\n").map((line) => line.trim()).filter((line) => line !== "");
}

const CONDITION = /^(.+?)\s*(>=|≥|<=|≤|=)\s*(.+)$/;

function readParameters(text: string, { problems }: FieldReader<RuleField>): Pick<AlertFilterShape, "least" | "most" | "equal"> {
  const [least, most, equal]: [Record<string, number>, Record<string, number>, Record<string, readonly string[]>] = [{}, {}, {}];
  for (const line of linesOf(text)) {
    const [, name = "", sign = "", value = ""] = CONDITION.exec(line) ?? [];
    if (sign === "=") {
      equal[name] = value.split(",").map((pattern) => pattern.trim()).filter((pattern) => pattern !== "");
      continue;
    }
    const number = Number(value.replace(",", ".").replace("−", "-"));
    if (sign === "" || value === "" || !Number.isFinite(number)) problems.set("parameters", msg(str`“${line}” is no condition: write Rate_Signif >= 7, Rate_Signif <= 99, or Packet_Type = 61, 67.`));
    else if (sign === ">=" || sign === "≥") least[name] = number;
    else most[name] = number;
  }
  return { least, most, equal };
}

/** The form of a rule that is kept. */
export function ruleDraft({ name, filter = {}, hours = 24, priority = 10, active = true }: AlertRuleShape): RuleDraft {
  const { sources = [], roles = ["observation"], largest_error: error = 0, lowest_declination: low = -90, highest_declination: high = 90, least = {}, most = {}, equal = {} } = filter;
  const parameters = [
    ...Object.entries(least).map(([parameter, value]) => `${parameter} >= ${String(value)}`),
    ...Object.entries(most).map(([parameter, value]) => `${parameter} <= ${String(value)}`),
    ...Object.entries(equal).map(([parameter, values]) => `${parameter} = ${values.join(", ")}`),
  ];
  return {
    name,
    sources: sources.join("\n"),
    roles,
    largestError: error === 0 ? "" : String(error),
    lowestDec: low === -90 ? "" : String(low),
    highestDec: high === 90 ? "" : String(high),
    parameters: parameters.join("\n"),
    hours: String(hours),
    priority: String(priority),
    active,
  };
}

/** What a rule takes of a field, as a group whose form can be filled: the zenith stands for the place that a notice will name. */
export function ruleGroup(rule: Pick<AlertRuleShape, "configurations" | "constraints"> | null, nowUs: number): GroupShape {
  const request: RequestShape = {
    id: "rule",
    target: { type: "FIXED", name: "", altitude: 90, azimuth: 0 },
    configurations: rule?.configurations ?? [{ exposure: 60, count: 5, guiding: "OPTIONAL" }],
    constraints: rule?.constraints ?? { min_altitude: 30 },
    windows: [{ start_us: nowUs, end_us: nowUs + 86_400e6 }],
    state: "DRAFT", frames_done: [], failures: 0, charge_s: 0,
  };
  return {
    id: "rule", proposal: "rule", name: "", requester: "", mine: true, operator: "SINGLE", urgency: "RAPID_RESPONSE", priority: 10,
    created_us: 0, submitted_us: 0, approved_us: 0, approved_by: "", waits: false, charge_s: 0, requests: [request], may: [],
  };
}

/** What a filter asks, in words, for a list. */
export function filterText({ sources = [], roles = [], largest_error: error = 0, lowest_declination: low = -90, highest_declination: high = 90, least = {}, most = {}, equal = {} }: AlertFilterShape): string {
  const parts = [
    sources.length === 0 ? msg("from anybody") : msg(str`from ${eitherText(sources)}`, { id: "from.senders" }),
    eitherText(roles),
    error === 0 ? "" : msg(str`known to ${String(error)}° or better`),
    low === -90 && high === 90 ? "" : msg(str`declination ${String(low).replace("-", "−")}° to ${String(high).replace("-", "−")}°`),
    ...Object.entries(least).map(([name, value]) => msg(str`${name} at least ${String(value)}`)),
    ...Object.entries(most).map(([name, value]) => msg(str`${name} at most ${String(value)}`)),
    ...Object.entries(equal).map(([name, values]) => msg(str`${name} is ${eitherText(values)}`)),
  ];
  return parts.filter(Boolean).join(", ");
}

