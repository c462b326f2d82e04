/** Write a note, or change one: its words, what it is about, and from when to when. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { formText } from "../../format/form-values.js";
import { knownZone } from "../../format/time.js";
import type { SiteShape } from "../../generated/api.js";
import { clockOf, momentProblem, type ZoneClock } from "../../series/zone-clock.js";
import { apiContext, sessionContext } from "../../state/contexts.js";
import { mayUse } from "../../state/rights.js";
import type { HubApi } from "../../wire/hub-api.js";
import { NotesApi } from "./notes-api.js";
import type { NoteDraft } from "./notes-query.js";
import "../../elements/feedback/dialog.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

/** As many as the hub takes. */
const LONGEST = 4000;

interface Mistakes {
  readonly text?: string;
  readonly from?: string;
  readonly to?: string;
}

/**
 * @fires t-saved it was written
 * @fires t-close when it was closed, by whatever way
 */
@customElement("t-note-dialog")
export class NoteDialog extends LitElement {
  static override styles = [
    base,
    forms,
    css`
      textarea {
        resize: vertical;
      }
    `,
  ];

  @property() site = "";
  @property() zone = "UTC";
  @property({ attribute: false }) detail: SiteShape | null = null;
  /** What it begins with; null while nothing is written. */
  @property({ attribute: false }) draft: NoteDraft | null = null;

  @state() private device = "";
  @state() private mistakes: Mistakes = {};
  @query("form") private readonly form!: HTMLFormElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly action = new ActionController(this);

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (!changed.has("draft") || this.draft === null) return;
    const places = this.places(this.draft);
    const wanted = this.draft.device;
    // Who may not write about the whole site begins with what they may write about.
    this.device = places.some(([id]) => id === wanted) ? wanted : (places[0]?.[0] ?? "");
    this.mistakes = {};
    this.action.clear();
  }

  protected override updated(changed: PropertyValues<this>): void {
    const { draft } = this;
    if (!changed.has("draft") || draft === null) return;
    const clock = this.clock();
    const fill = (name: string, text: string): void => {
      const field = this.form.elements.namedItem(name);
      if (field instanceof HTMLInputElement || field instanceof HTMLTextAreaElement) field.value = text;
    };
    fill("text", draft.text);
    fill("from", clock.toInput(draft.fromUs));
    fill("to", draft.toUs > draft.fromUs ? clock.toInput(draft.toUs) : "");
    void focusInside(this, "textarea");
  }

  override render(): TemplateResult {
    const { draft, mistakes, device } = this;
    const { zone } = this.clock();
    const signals = this.detail?.devices.find(({ id }) => id === device)?.signals ?? [];
    const chosen = draft?.device === device ? draft.signal : "";
    return html`<t-dialog heading=${(draft?.id ?? "") === "" ? msg("Write a note") : msg("Change the note")} ?open=${draft !== null} @t-close=${this.onClosed}>
      <form class="entry" novalidate @submit=${this.onSubmit}>
        <t-field class="wide" label=${msg("Text")} .error=${mistakes.text ?? ""}><textarea name="text" rows="4" maxlength=${LONGEST}></textarea></t-field>
        <t-field label=${msg(str`From (${zone})`)} .error=${mistakes.from ?? ""}><input name="from" type="text" autocomplete="off" maxlength="30" placeholder="2026-03-29 14:05:09" /></t-field>
        <t-field label=${msg(str`To (${zone})`)} hint=${msg("Empty: a note at a moment.")} .error=${mistakes.to ?? ""}><input name="to" type="text" autocomplete="off" maxlength="30" placeholder="2026-03-29 14:05:09" /></t-field>
        <t-field label=${msg("About")}><select name="device" @change=${this.onDevice}>${renderOptions(draft === null ? [] : this.places(draft), device)}</select></t-field>
        <t-field label=${msg("Signal")}><select name="signal" ?disabled=${device === ""}>${renderOptions([["", msg("none of its own")], ...signals.map(({ id, name }) => [id, name] as const)], chosen)}</select></t-field>
        ${renderAdvice(this.action.problem)}
      </form>
      <t-button slot="actions" @click=${this.closeDialog}>${msg("Cancel")}</t-button>
      <t-button slot="actions" kind="primary" ?busy=${this.action.busy} @click=${this.save}>${msg("Save")}</t-button>
    </t-dialog>`;
  }

  /** What the person may write about, the whole site first; what a note is about already stays. */
  private places({ device }: NoteDraft): (readonly [id: string, name: string])[] {
    const person = this.session.store?.person;
    const { site } = this;
    const devices = (this.detail?.devices ?? []).filter(({ id, rights }) => rights.includes("use") || id === device).map(({ id, name }) => [id, name] as const);
    const former = device !== "" && !devices.some(([id]) => id === device) ? [[device, device] as const] : [];
    return [...(mayUse(person, site, "") ? [["", msg("The whole site")] as const] : []), ...devices, ...former];
  }

  private clock(): ZoneClock {
    return clockOf(knownZone(this.zone));
  }

  /** The moment of a field; what was not touched stays exact, for a field holds whole seconds. */
  private momentOf(text: string, before: number): number {
    const clock = this.clock();
    return text === clock.toInput(before) ? before : clock.fromInput(text);
  }

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    this.save();
  };

  private readonly save = (): void => {
    const { draft } = this;
    if (draft === null) return;
    const said = new FormData(this.form);
    const [text, from, to] = [formText(said, "text"), formText(said, "from"), formText(said, "to")];
    const fromUs = this.momentOf(from, draft.fromUs);
    const toUs = to === "" ? fromUs : this.momentOf(to, draft.toUs);
    const wrongTo = momentProblem(to, toUs) || (toUs < fromUs ? msg("It ends before it begins.") : "");
    this.mistakes = {
      ...(text === "" ? { text: msg("Write some words.") } : {}),
      ...(Number.isNaN(fromUs) ? { from: momentProblem(from || "?", fromUs) } : {}),
      ...(wrongTo === "" ? {} : { to: wrongTo }),
    };
    if (Object.keys(this.mistakes).length > 0) return;
    const note = { text, device: this.device, signal: formText(said, "signal"), from_us: fromUs, to_us: toUs };
    const api = new NotesApi(this.api, this.site);
    const keep = draft.id === "" ? () => api.addNote(note) : () => api.changeNote(draft.id, { ...note, base: draft.version });
    void this.action.run(msg("save the note"), keep).then((done) => {
      if (done) this.dispatchEvent(new CustomEvent("t-saved"));
    });
  };

  private readonly onDevice = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.device = event.target.value;
  };

  private readonly closeDialog = (): void => {
    this.dispatchEvent(new CustomEvent("t-close"));
  };

  private readonly onClosed = (): void => {
    this.closeDialog();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-note-dialog": NoteDialog;
  }
}
