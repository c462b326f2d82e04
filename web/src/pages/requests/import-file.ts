/** A file of requests that another program wrote: whose it is, and what is said of what was read. Pure. */

import { msg, str } from "@lit/localize";
import { plural } from "../../words/plural.js";
import type { FileKind, GroupAsk, ImportAnswer } from "../../generated/api.js";

export const FILE_KINDS = ["csv", "lco", "nina", "ekos"] as const satisfies readonly FileKind[];
export const FILE_KIND_WORDS: Readonly<Record<FileKind, string>> = {
  csv: msg("Table (CSV)"),
  lco: msg("Las Cumbres (JSON)"),
  nina: msg("N.I.N.A. sequence (JSON)"),
  ekos: msg("Ekos list (.esl)"),
};
/** With what is sent beside it, a body has to stay below the hub's 1 MiB. */
export const MOST_CHARACTERS = 900_000;

/** Guesses from what stands in a file, and from its name where that tells nothing. */
export function guessKind(name: string, text: string): FileKind {
  const begin = text.replace(/^\ufeff/, "").trimStart();
  const ending = /\.(\w+)$/.exec(name.toLowerCase())?.[1] ?? "";
  if (begin.startsWith("<") || ending === "esl") return "ekos";
  if (begin.startsWith("{") || begin.startsWith("[") || ending === "json") return begin.includes('"$type"') ? "nina" : "lco";
  return "csv";
}

/** What was read, in a sentence. */
export function readText({ groups, problems }: ImportAnswer): string {
  const requests = groups.reduce((sum, group) => sum + group.requests.length, 0);
  const found = requests === 0 ? msg("No request could be read") : msg(str`${plural(requests, msg("1 request"), msg(str`${String(requests)} requests`))} in ${plural(groups.length, msg("1 group"), msg(str`${String(groups.length)} groups`))}`);
  return problems.length === 0 ? `${found}.` : msg(str`${found}; ${plural(problems.length, msg("1 part"), msg(str`${String(problems.length)} parts`))} could not be read and would be left out.`);
}

/** What a group is called in a list: its name, or its first targets. */
export function groupTitle({ name, requests }: GroupAsk, most = 4): string {
  const targets = requests.map(({ target }) => (target == null || (target.name ?? "") === "" ? msg("no name") : (target.name ?? "")));
  const shown = targets.slice(0, most).join(", ") + (targets.length > most ? msg(str` and ${String(targets.length - most)} more`) : "");
  return name === undefined || name === "" ? shown : `${name}: ${shown}`;
}

/** Open shutter of a group (s). */
export function shutterOf({ requests }: GroupAsk): number {
  return requests.reduce((sum, { configurations }) => sum + configurations.reduce((part, { exposure, count = 1 }) => part + exposure * count, 0), 0);
}
