/** A mission while it is written in a form: what was typed, and the mission that it makes. Pure. */

import { msg, str } from "@lit/localize";
import { checkArgument, initialText, type ArgumentValue } from "../../elements/command/argument-check.js";
import type { CommandShape, MissionScheduleShape, MissionShape, MissionStepShape, SiteShape, StepKind } from "../../generated/api.js";

export const DAYS = [["mon", msg("Mon")], ["tue", msg("Tue")], ["wed", msg("Wed")], ["thu", msg("Thu")], ["fri", msg("Fri")], ["sat", msg("Sat")], ["sun", msg("Sun", { id: "sun.day" })]] as const;
export const KINDS = [["command", msg("Command")], ["until", msg("Wait until")], ["pause", msg("Wait for a time")]] as const;
/** never: it begins when somebody presses start. */
export type ScheduleKind = "never" | "weekly" | "once";

/** One step as it is typed. */
export interface StepDraft {
  /** Tells it from the others while they are moved. */
  readonly key: number;
  readonly kind: StepKind;
  readonly name: string;
  /** `<device>/<command>`; empty before one is chosen. */
  readonly command: string;
  readonly typed: Readonly<Record<string, string>>;
  readonly condition: string;
  readonly seconds: string;
  readonly goesOn: boolean;
}

export interface MissionDraft {
  /** Empty for a new one. */
  readonly id: string;
  readonly name: string;
  readonly note: string;
  readonly steps: readonly StepDraft[];
  readonly schedule: ScheduleKind;
  readonly at: string;
  readonly days: readonly string[];
  readonly date: string;
}

/** What is wrong, by where: `name`, `at`, `date`, or `<step key>/<field>`. */
export type DraftErrors = Readonly<Record<string, string>>;

let lastKey = 0;

export function emptyStep(kind: StepKind = "command"): StepDraft {
  lastKey += 1;
  return { key: lastKey, kind, name: "", command: "", typed: {}, condition: "", seconds: kind === "pause" ? "10" : "", goesOn: false };
}

export function emptyDraft(): MissionDraft {
  return { id: "", name: "", note: "", steps: [emptyStep()], schedule: "never", at: "06:00", days: [], date: "" };
}

export function draftOf(id: string, mission: MissionShape): MissionDraft {
  const { schedule } = mission;
  return {
    id,
    name: mission.name,
    note: mission.note,
    steps: mission.steps.map((step) => ({
      ...emptyStep(step.kind),
      name: step.name,
      command: step.command === "" ? "" : `${step.device}/${step.command}`,
      typed: Object.fromEntries(Object.entries(step.args).map(([key, value]) => [key, String(value)])),
      condition: step.condition,
      seconds: step.seconds > 0 ? String(step.seconds) : "",
      goesOn: step.goes_on,
    })),
    schedule: schedule === null ? "never" : schedule.date === "" ? "weekly" : "once",
    at: schedule?.at ?? "06:00",
    days: schedule?.days ?? [],
    date: schedule?.date ?? "",
  };
}

/** The steps with one of them moved up (-1) or down (1). */
export function movedStep(steps: readonly StepDraft[], key: number, by: -1 | 1): readonly StepDraft[] {
  const at = steps.findIndex((step) => step.key === key);
  const moved = steps[at];
  const other = steps[at + by];
  if (moved === undefined || other === undefined) return steps;
  return steps.map((step) => (step === moved ? other : step === other ? moved : step));
}

/** A command of a site by `<device>/<command>`. */
export function commandAt(site: SiteShape | null, address: string): CommandShape | null {
  const [device = "", command = ""] = address.split("/");
  return site?.devices.find(({ id }) => id === device)?.commands.find(({ id }) => id === command) ?? null;
}

/** The mission that a draft makes, or what is wrong with it. */
export function readDraft(draft: MissionDraft, site: SiteShape): { readonly mission: MissionShape | null; readonly errors: DraftErrors } {
  const errors: Record<string, string> = {};
  if (draft.name.trim() === "") errors["name"] = msg("Give it a name.");
  const steps = draft.steps.map((step) => readStep(step, site, errors));
  if (draft.schedule !== "never" && draft.at === "") errors["at"] = msg("Give a time of day.");
  if (draft.schedule === "once" && draft.date === "") errors["date"] = msg("Give a day.");
  const schedule: MissionScheduleShape | null =
    draft.schedule === "never" ? null : { at: draft.at, days: draft.schedule === "weekly" ? [...draft.days] : [], date: draft.schedule === "once" ? draft.date : "" };
  const mission = { name: draft.name.trim(), note: draft.note.trim(), steps, schedule };
  return Object.keys(errors).length > 0 ? { mission: null, errors } : { mission, errors };
}

function readStep(step: StepDraft, site: SiteShape, errors: Record<string, string>): MissionStepShape {
  const at = (field: string): string => `${String(step.key)}/${field}`;
  const made = { kind: step.kind, name: step.name.trim(), device: "", command: "", args: {}, units: {}, condition: "", seconds: readSeconds(step, errors), goes_on: step.goesOn };
  if (step.kind === "pause") return made;
  if (step.kind === "until") {
    if (step.condition.trim() === "") errors[at("condition")] = msg("Say what is waited for.");
    return { ...made, condition: step.condition.trim() };
  }
  const command = commandAt(site, step.command);
  if (command === null) {
    errors[at("command")] = msg("Choose a command.");
    return made;
  }
  const args: Record<string, ArgumentValue> = {};
  for (const argument of command.arguments) {
    const checked = checkArgument(argument, step.typed[argument.id] ?? initialText(argument));
    if (checked.ok) args[argument.id] = checked.value;
    else errors[at(argument.id)] = checked.why;
  }
  const [device = "", id = ""] = step.command.split("/");
  // In the units that stand beside the fields now.
  const units = Object.fromEntries(command.arguments.map(({ id: name, unit }) => [name, unit]));
  return { ...made, device, command: id, args, units };
}

function readSeconds(step: StepDraft, errors: Record<string, string>): number {
  const seconds = step.seconds.trim() === "" ? 0 : Number(step.seconds.replace(",", "."));
  const good = Number.isFinite(seconds) && seconds >= 0 && seconds <= 86_400 && (step.kind !== "pause" || seconds > 0);
  if (!good) errors[`${String(step.key)}/seconds`] = step.kind === "pause" ? msg("More than 0 s, at most 86400 s.") : msg("0 to 86400 s.");
  return good ? seconds : 0;
}

/** When it begins by itself, in words. */
export function scheduleText(schedule: MissionScheduleShape | null): string {
  if (schedule === null) return msg("begins when somebody presses start");
  if (schedule.date !== "") return msg(str`once, on ${schedule.date} at ${schedule.at}`);
  const names = DAYS.filter(([day]) => schedule.days.includes(day)).map(([, name]) => name);
  return msg(str`${names.length === 0 || names.length === 7 ? msg("every day") : names.join(", ")} at ${schedule.at}`);
}
