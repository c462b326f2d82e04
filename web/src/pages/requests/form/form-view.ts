/** What the parts of the form draw from, and how each draws a field: label with unit, help, and what is wrong. */

import { html, type TemplateResult } from "lit";
import { settled } from "../../../elements/base/stable-field.js";
import type { AbilitiesShape, ProposalShape } from "../../../generated/api.js";
import type { GroupDraft, GroupField, RequestDraft, RequestField } from "./draft.js";
import type { ReadGroup, ReadRequest } from "./read-draft.js";
import "../../../elements/forms/field.js";

export interface OpenedParts {
  readonly motion: boolean;
  readonly phase: boolean;
}

export function openedParts({ motionRa, motionDec, epoch, phasePeriod, phaseEpoch, phaseStart, phaseEnd }: RequestDraft): OpenedParts {
  const isWritten = (...texts: readonly string[]): boolean => texts.some((text) => text !== "");
  return { motion: isWritten(motionRa, motionDec, epoch), phase: isWritten(phasePeriod, phaseEpoch, phaseStart, phaseEnd) };
}

export interface FormView {
  readonly draft: GroupDraft;
  readonly read: ReadGroup;
  /** Which request is shown, as it is typed and as it was read. */
  readonly at: number;
  readonly request: RequestDraft;
  readonly readRequest: ReadRequest;
  readonly proposals: readonly ProposalShape[];
  readonly abilities: AbilitiesShape | null;
  readonly zone: string;
  /** Which rarer parts were written in when the request was shown; typing neither opens nor closes them. */
  readonly opened: OpenedParts;
  /** What is wrong in an untouched field is said once the person has tried to send it. */
  readonly tried: boolean;
}

export function renderGroupField(view: FormView, field: GroupField, label: string, control: TemplateResult, hint = ""): TemplateResult {
  const untouched = !view.tried && field === "proposal" && view.draft.proposal === "";
  return html`<t-field .label=${label} .hint=${hint} .error=${untouched ? "" : (view.read.problems.get(field) ?? "")}>${control}</t-field>`;
}

export function renderRequestField(view: FormView, field: RequestField, label: string, control: TemplateResult, hint = ""): TemplateResult {
  const untouched = !view.tried && (field === "ra" || field === "dec") && view.request[field] === "";
  return html`<t-field .label=${label} .hint=${hint} .error=${untouched ? "" : (view.readRequest.problems.get(field) ?? "")}>${control}</t-field>`;
}

export function numberInput(name: string, value: string): TemplateResult {
  return html`<input name=${name} inputmode="decimal" autocomplete="off" maxlength="40" .value=${settled(value)} />`;
}
