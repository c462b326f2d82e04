/** Parts of the form: what a group is for, and which of its requests is shown. */

import { msg, str } from "@lit/localize";
import { html, nothing, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { settled } from "../../../elements/base/stable-field.js";
import { renderOptions } from "../../../elements/forms/form-parts.js";
import { URGENCY_WORDS } from "../../../format/observing-words.js";
import { plural } from "../../../words/plural.js";
import { MOST_REQUESTS, URGENCIES, type RequestDraft } from "./draft.js";
import { numberInput, renderGroupField, type FormView } from "./form-view.js";
import "../../../elements/forms/button.js";

export function renderPurpose(view: FormView): TemplateResult {
  const { draft } = view;
  const own = view.proposals.filter(({ may_ask: may, active, id }) => (may && active) || id === draft.proposal);
  const chosen = own.find(({ id }) => id === draft.proposal);
  const urgencies = URGENCIES.filter((urgency) => urgency === "NORMAL" || urgency === draft.urgency || chosen?.urgencies.includes(urgency) === true);
  return html`<fieldset>
    <legend>${msg("What it is for")}</legend>
    ${renderGroupField(view, "proposal", msg("Proposal"), html`<select name="proposal">${renderOptions([["", "choose"], ...own.map(({ id, title }) => [id, title === "" ? id : `${id}: ${title}`] as const)], draft.proposal)}</select>`)}
    ${renderGroupField(view, "name", msg("Name"), html`<input name="name" maxlength="200" autocomplete="off" .value=${settled(draft.name)} />`, msg("As you will find it again"))}
    <t-field label=${msg("Urgency")} hint=${msg("What is urgent goes first; a rapid response interrupts")}><select name="urgency">${renderOptions(urgencies.map((urgency) => [urgency, URGENCY_WORDS[urgency]] as const), draft.urgency)}</select></t-field>
    ${renderGroupField(view, "priority", msg("Priority"), numberInput("priority", draft.priority), chosen === undefined ? msg("What a minute of it is worth beside others") : msg(str`Up to ${String(chosen.max_priority)} in this proposal`))}
  </fieldset>`;
}

/** What is done to the list; a `DraftEditor` does it. */
export interface RequestListActions {
  show(at: number): void;
  readonly addRequest: () => void;
  readonly copyRequest: () => void;
  readonly removeRequest: () => void;
  readonly moveEarlier: () => void;
  readonly moveLater: () => void;
}

/** Of one request hardly anything; of several their list, their order and how they belong together. */
export function renderRequestList(view: FormView, actions: RequestListActions): TemplateResult {
  const { draft, at } = view;
  const many = draft.requests.length;
  return html`<fieldset>
    <legend>${plural(many, msg("One request"), msg(str`${String(many)} requests`))}</legend>
    ${many === 1
      ? nothing
      : html`<t-field label=${msg("They belong together as")} hint=${msg("A sequence: each only once the one before it is done")}
            ><select name="operator">${renderOptions([["MANY", msg("many, in any order")], ["SEQUENCE", msg("a sequence")]], draft.operator === "SEQUENCE" ? "SEQUENCE" : "MANY")}</select></t-field
          >
          <div class="requests wide" role="group" aria-label=${msg("Requests of this group")}>${map(draft.requests, (request, i) => renderChoice(view, request, i, actions))}</div>`}
    <div class="actions wide">
      <t-button ?disabled=${many >= MOST_REQUESTS} @click=${actions.addRequest}>${msg("Add a request")}</t-button>
      <t-button ?disabled=${many >= MOST_REQUESTS} @click=${actions.copyRequest}>${msg("Copy this one")}</t-button>
      ${many === 1
        ? nothing
        : html`<t-button kind="quiet" ?disabled=${at === 0} @click=${actions.moveEarlier}>${msg("Earlier")}</t-button>
            <t-button kind="quiet" ?disabled=${at === many - 1} @click=${actions.moveLater}>${msg("Later")}</t-button>
            <t-button kind="quiet" label=${msg(str`Remove request ${String(at + 1)}`)} @click=${actions.removeRequest}>${msg("Remove this one")}</t-button>`}
    </div>
    ${view.read.problems.has("requests") ? html`<p class="wide wrong" role="alert">${view.read.problems.get("requests")}</p>` : nothing}
  </fieldset>`;
}

function renderChoice({ read, at, tried }: FormView, request: RequestDraft, i: number, actions: RequestListActions): TemplateResult {
  const wrong = tried ? (read.requests[i]?.problems.size ?? 0) : 0;
  const name = `${String(i + 1)} ${requestTitle(request)}`;
  const said = wrong === 0 ? "" : plural(wrong, msg(": a field needs another look"), msg(str`: ${String(wrong)} fields need another look`));
  const show = (): void => {
    actions.show(i);
  };
  return html`<t-button kind="plain" pressed=${i === at ? "true" : "false"} label=${msg(str`Request ${name}${said}`)} @click=${show}>${name}${wrong === 0 ? "" : " ⚠"}</t-button>`;
}

/** What a request is called before it is kept. */
export function requestTitle({ way, target, body }: RequestDraft): string {
  if (way === "none") return msg("no target");
  if (target.trim() !== "") return target.trim();
  return way === "body" ? body : msg("no name");
}
