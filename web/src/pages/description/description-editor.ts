/** Changes a site's description, as a form or as text: checked while one goes, applied when told. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import type { ActionController } from "../../controllers/action.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import { styled } from "../../elements/base/style-directive.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { adviceFor, type Advice } from "../../format/error-advice.js";
import { plural } from "../../words/plural.js";
import { apiContext } from "../../state/contexts.js";
import { EditHistory } from "../../state/edit-history.js";
import { DescriptionsApi, type Schema } from "../../wire/descriptions-api.js";
import type { ChangeAnswer, CheckAnswer, DescriptionList, FindingShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { applyEdit, changedDevices, isObject, type FormEdit, type JsonObject } from "./json-schema.js";
import { withSensor, type NewSensor } from "./new-sensor.js";
import { refusalAdvice } from "./refusal-advice.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "./description-diff.js";
import "./description-problems.js";
import "./schema-form.js";
import "./description-preview.js";

/** A text is checked so long after the last key (ms). */
const REST_MS = 400;
const VIEWS = [
  { id: "form", label: msg("Form") },
  { id: "text", label: msg("Text") },
];

@customElement("t-description-editor")
export class DescriptionEditor extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      textarea {
        inline-size: 100%;
        min-block-size: 32rem;
        padding: var(--t-space-3);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
        line-height: 1.5;
        white-space: pre;
        overflow: auto;
        tab-size: 2;
      }
      .pad {
        position: relative;
      }
      .marks {
        position: absolute;
        inset-block: 1px;
        inset-inline-start: 1px;
        inline-size: var(--t-space-2);
        overflow: hidden;
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
        line-height: 1.5;
      }
      .marks span {
        position: absolute;
        inset-inline: 0;
        inset-block-start: calc(var(--t-space-3) + var(--line) * 1.5em - var(--scrolled));
        block-size: 1.5em;
        background: var(--t-bad);
      }
      .marks .note {
        background: var(--t-warn);
      }
      textarea:focus-visible {
        outline: 3px solid var(--t-accent);
        outline-offset: 1px;
      }
      .tools {
        position: sticky;
        inset-block-start: 3.4rem;
        z-index: 5;
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        justify-content: space-between;
        gap: var(--t-space-2);
        padding-block: var(--t-space-2);
        background: var(--t-surface);
      }
      h3 {
        margin: 0;
        font-size: var(--t-size-m);
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) known: DescriptionList | null = null;

  /** A sensor of the robot to begin with a signal for; null for none. */
  @property({ attribute: false }) sensor: NewSensor | null = null;

  @state() private view = "form";
  @state() private edits: EditHistory | null = null;
  @state() private checked: CheckAnswer | null = null;
  @state() private described: JsonObject | null = null;
  @state() private schema: Schema | null = null;
  @state() private failed: Advice | null = null;
  @state() private answer: ChangeAnswer | null = null;

  /** How far the text is scrolled (CSS pixels); the marks move with it. */
  @state() private scrolled = 0;
  @query("textarea") private readonly area!: HTMLTextAreaElement | null;
  @consume({ context: apiContext }) private readonly api!: HubApi;
  /** Whether to apply the text as it stands. */
  private readonly review = new QuestionController<EditHistory>(this, (edits, action) => this.applyText(edits, action));
  private from = { site: "", number: 0, digest: "", text: "" };
  private timer = 0;
  private abort: AbortController | null = null;
  private typing = 0;

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
    this.abort?.abort();
  }

  override willUpdate(): void {
    const newest = this.known?.versions[0];
    if (newest === undefined) return;
    const untouched = this.edits === null || this.edits.text === this.from.text;
    if (this.site !== this.from.site || (untouched && newest.number !== this.from.number)) void this.load(newest.number);
  }

  override render(): TemplateResult {
    if (this.failed !== null) {
      return renderAdvice(this.failed, this.reload);
    }
    if (this.edits === null) return html`<t-loading what=${msg("Loading the text")}></t-loading>`;
    const { edits } = this;
    const moved = this.known !== null && this.known.versions[0]?.number !== this.from.number;
    return html`${moved
        ? html`<t-problem
            what=${msg("The description was changed meanwhile.")}
            how=${msg("What you have done so far was made from an older one.")}
            retry=${msg("Begin with the newest")}
            @t-retry=${this.reload}
          ></t-problem>`
        : nothing}
      <section class="sheet" aria-label=${msg("Editor")} @keydown=${this.onKeyDown}>
        <div class="tools">
          <t-choice label=${msg("View")} .options=${VIEWS} chosen=${this.view} @t-choose=${this.onTabChange}></t-choice>
          <div class="actions">
            <t-button ?disabled=${!edits.canUndo} @click=${this.undo}>${msg("Undo")}</t-button>
            <t-button ?disabled=${!edits.canRedo} @click=${this.redo}>${msg("Redo")}</t-button>
            <t-button kind="primary" ?disabled=${!this.canApply()} @click=${this.openReview}>${msg("Review and apply")}</t-button>
          </div>
        </div>
        ${this.renderStatus()} ${this.renderSensor()}
        ${this.view === "text"
          ? html`<div class="pad">
              <textarea
                aria-label=${msg("The description as YAML")}
                spellcheck="false"
                autocapitalize="off"
                .value=${edits.text}
                @input=${this.onInput}
                @scroll=${this.onScroll}
              ></textarea>
              ${this.renderMarks()}
            </div>`
          : this.renderForm()}
      </section>
      ${this.renderConfirm()}`;
  }

  private renderSensor(): unknown {
    const { sensor, described } = this;
    if (sensor === null || described === null || withSensor(described, sensor) !== described) return nothing;
    return html`<p class="muted">${msg(str`A signal for ${sensor.name} of ${sensor.topic} is in the form. It counts once you have applied it.`)}</p>`;
  }

  private renderStatus(): TemplateResult {
    const { checked } = this;
    if (checked === null) return html`<t-status kind="busy" word=${msg("checking")}></t-status>`;
    const wrong = checked.findings.filter(({ note }) => !note);
    const list = html`<t-findings places .findings=${checked.findings} @t-place=${this.showProblem}></t-findings>`;
    if (wrong.length === 0) {
      const same = this.edits?.text === this.from.text;
      return html`<t-status kind="ok" word=${same ? msg("nothing changed yet") : msg("fits together")}></t-status>
        ${checked.findings.length === 0 ? nothing : list}`;
    }
    const count = wrong.length;
    return html`<t-status kind="bad" word=${plural(count, msg("1 thing does not fit"), msg(str`${String(count)} things do not fit`))}></t-status>
      ${list}`;
  }

  /** A mark at each line that has a problem; the list above says it to who cannot see them. */
  private renderMarks(): TemplateResult {
    const lines = new Map<number, FindingShape[]>();
    for (const problem of this.checked?.findings ?? []) if (problem.line > 0) lines.set(problem.line, [...(lines.get(problem.line) ?? []), problem]);
    return html`<div class="marks" aria-hidden="true">
      ${map(
        lines,
        ([line, found]) => html`<span
          class=${found.every(({ note }) => note) ? "note" : ""}
          title=${found.map(({ problem, remedy }) => [problem, remedy].filter(Boolean).join("; ")).join("\n")}
          ${styled({ "--line": String(line - 1), "--scrolled": `${String(this.scrolled)}px` })}
        ></span>`,
      )}
    </div>`;
  }

  private readonly onScroll = (event: Event): void => {
    this.scrolled = (event.target as HTMLTextAreaElement).scrollTop;
  };

  private renderForm(): TemplateResult {
    if (this.schema === null) return html`<t-loading what=${msg("Making the form")}></t-loading>`;
    if (this.described === null) {
      return html`<p class="muted">${msg("The text cannot be read as a description. Mend it in the text, or take the last step back.")}</p>`;
    }
    return html`<t-form-part
      .root=${this.schema}
      .schema=${this.schema}
      .value=${this.described}
      .findings=${this.checked?.findings ?? []}
      @t-edit=${this.onFormEdit}
    ></t-form-part>`;
  }

  private renderConfirm(): TemplateResult {
    const { answer, checked } = this;
    return renderQuestion(this.review, () => ({
      heading: msg("Apply this change?"),
      action: this.review.action.busy ? msg("The gateway changes over…") : msg("Apply"),
      kind: "primary",
      problem: refusalAdvice(answer),
      text: html`<t-difference .parts=${checked?.parts ?? []} .lines=${checked?.lines ?? []}></t-difference>
        <h3>${msg("Preview")}</h3>
        <t-description-preview .described=${this.described ?? {}} .devices=${changedDevices(checked?.parts ?? [])}></t-description-preview>
        <p>${msg("The gateway applies it at once. A device that changes is stopped first, and its driver loses control.")}</p>
        ${answer === null || answer.findings.length === 0 ? nothing : html`<t-findings .findings=${answer.findings}></t-findings>`}`,
    }));
  }

  private canApply(): boolean {
    const changed = this.edits !== null && this.edits.text !== this.from.text;
    return changed && this.checked !== null && this.checked.findings.every(({ note }) => note) && this.known?.editable === true;
  }

  private async load(number: number): Promise<void> {
    const { site } = this;
    this.from = { site, number, digest: "", text: "" };
    const api = new DescriptionsApi(this.api);
    try {
      const [found, schema] = await Promise.all([api.versionText(site, number), this.schema ?? api.schema()]);
      if (site !== this.from.site || number !== this.from.number) return;
      this.from = { site, number, digest: found.digest, text: found.text };
      this.schema = schema;
      this.failed = null;
      this.edits = new EditHistory(found.text);
      await this.checkText();
      // Into the form only: what it changes is reviewed as any other edit.
      if (this.sensor?.site === site && this.described !== null) this.changeForm(withSensor(this.described, this.sensor));
    } catch (error) {
      this.failed = adviceFor(error, msg("the description"));
    }
  }

  /** Has the hub look at the text as it is now. */
  private async checkText(): Promise<void> {
    clearTimeout(this.timer);
    this.abort?.abort();
    const abort = (this.abort = new AbortController());
    const { edits, from } = this;
    if (edits === null) return;
    try {
      const checked = await new DescriptionsApi(this.api).checkText(from.site, edits.text, from.number, abort.signal);
      if (abort.signal.aborted) return;
      this.checked = checked;
      this.described = isObject(checked.site) ? checked.site : null;
    } catch (error) {
      if (!abort.signal.aborted) this.failed = adviceFor(error, msg("a check of the text"));
    }
  }

  private readonly onFormEdit = (event: CustomEvent<FormEdit>): void => {
    event.stopPropagation();
    if (this.described !== null) this.changeForm(applyEdit(this.described, event.detail));
  };

  private changeForm(wanted: JsonObject): void {
    if (wanted === this.described || this.edits === null) return;
    // What the hub says of the text before must not take this back.
    this.abort?.abort();
    this.described = wanted;
    this.checked = null;
    void this.writeFormToText(this.edits, wanted);
  }

  /** Puts what the form says into the text; the hub keeps comments and order. */
  private async writeFormToText(edits: EditHistory, wanted: JsonObject): Promise<void> {
    try {
      const made = await new DescriptionsApi(this.api).editText(this.from.site, edits.text, wanted);
      if (this.described !== wanted) return;
      if (made.text === "") {
        this.checked = { findings: made.findings, site: wanted, parts: [], lines: [] };
        return;
      }
      edits.recordEdit(made.text);
      await this.checkText();
    } catch (error) {
      this.failed = adviceFor(error, msg("the text of the change"));
    }
  }

  private readonly onInput = (event: Event): void => {
    if (!(event.target instanceof HTMLTextAreaElement) || this.edits === null) return;
    const now = Date.now();
    this.edits.recordEdit(event.target.value, now - this.typing < 2 * REST_MS);
    this.typing = now;
    this.checked = null;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.checkText(), REST_MS);
  };

  private readonly undo = (): void => {
    this.edits?.undoEdit();
    this.checked = null;
    void this.checkText();
  };

  private readonly redo = (): void => {
    this.edits?.redoEdit();
    this.checked = null;
    void this.checkText();
  };

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    if (!(event.ctrlKey || event.metaKey) || event.altKey) return;
    const key = event.key.toLowerCase();
    if (key === "z" && !event.shiftKey) this.undo();
    else if (key === "y" || (key === "z" && event.shiftKey)) this.redo();
    else return;
    event.preventDefault();
  };

  private readonly onTabChange = (event: CustomEvent<string>): void => {
    this.view = event.detail;
  };

  /** Shows the place of a finding in the text. */
  private readonly showProblem = (event: CustomEvent<FindingShape>): void => {
    const { line } = event.detail;
    this.view = "text";
    void this.updateComplete.then(() => {
      const { area } = this;
      if (area === null) return;
      const lines = area.value.split("\n");
      const at = Math.max(0, line - 1);
      const start = lines.slice(0, at).reduce((sum, address) => sum + address.length + 1, 0);
      area.focus();
      area.setSelectionRange(start, start + (lines[at]?.length ?? 0));
      area.scrollTop = Math.max(0, (at / lines.length) * area.scrollHeight - area.clientHeight / 2);
    });
  };

  private readonly openReview = (event: Event): void => {
    this.answer = null;
    if (this.edits !== null) this.review.opener(this.edits)(event);
  };

  private readonly reload = (): void => {
    this.failed = null;
    this.edits = null;
    this.checked = null;
    void this.load(this.known?.versions[0]?.number ?? this.from.number);
  };

  /** Gives whether the gateway changed over. */
  private async applyText(edits: EditHistory, action: ActionController): Promise<boolean> {
    this.answer = null;
    const { text } = edits;
    const answered = await action.run(msg("apply the change"), async () => {
      this.answer = await new DescriptionsApi(this.api).sendDescription(this.site, text, this.from.digest);
    });
    if (!answered || (this.answer as ChangeAnswer | null)?.phase !== "applied") return false;
    this.from = { ...this.from, text };
    this.dispatchEvent(new CustomEvent("t-applied"));
    return true;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-description-editor": DescriptionEditor;
  }
}
