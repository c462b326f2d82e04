/** From what a person has drawn or chosen to a change of the description that a gateway is asked for. */

import type { ChangeAnswer, CheckAnswer, DescriptionText, FindingShape } from "../../generated/api.js";
import { DescriptionsApi } from "../../wire/descriptions-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import type { JsonObject } from "./json-schema.js";

/** A text that a gateway may go by, and what is other in it. */
export interface DraftChange extends Pick<CheckAnswer, "parts" | "lines"> {
  readonly text: string;
  /** SHA-256 of the text that it was made from. */
  readonly base: string;
  /** What does not fit; with any of it there is nothing to apply. */
  readonly findings: readonly FindingShape[];
}

/** Has the hub write it into the text, where comments and order stay, and check that. */
export async function draftChange(hub: HubApi, site: string, from: DescriptionText, wanted: JsonObject): Promise<DraftChange> {
  const api = new DescriptionsApi(hub);
  const made = await api.editText(site, from.text, wanted);
  if (made.text === "") return { text: "", base: from.digest, findings: made.findings, parts: [], lines: [] };
  const { findings, parts, lines } = await api.checkText(site, made.text, from.number);
  return { text: made.text, base: from.digest, findings: findings.filter(({ note }) => !note), parts, lines };
}

export function sendDraft(hub: HubApi, site: string, { text, base }: DraftChange): Promise<ChangeAnswer> {
  return new DescriptionsApi(hub).sendDescription(site, text, base);
}
