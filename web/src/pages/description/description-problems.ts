import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base, plainList } from "../../elements/base/base-style.js";
import type { FindingShape } from "../../generated/api.js";

/**
 * Problems in a description: where, what, what to do.
 *
 * @fires t-place detail is the finding that was pressed; only where `places` is set
 */
@customElement("t-findings")
export class DescriptionProblems extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        min-inline-size: 0;
      }
      ul {
        display: grid;
        gap: var(--t-space-1);
        ${plainList}
      }
      li {
        padding-inline-start: var(--t-space-3);
        border-inline-start: 3px solid var(--t-bad);
        overflow-wrap: anywhere;
      }
      button {
        min-block-size: var(--t-touch);
        padding: 0;
        border: 0;
        background: none;
        color: var(--t-accent);
        font: inherit;
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
        text-align: start;
        text-decoration: underline;
        cursor: pointer;
        overflow-wrap: anywhere;
      }
      li.note {
        border-color: var(--t-warn);
      }
      .remedy {
        color: var(--t-muted);
      }
    `,
  ];

  @property({ attribute: false }) findings: readonly FindingShape[] = [];
  /** Whether there is a place to go to. */
  @property({ type: Boolean }) places = false;

  override render(): TemplateResult {
    return html`<ul aria-label=${msg("Problems")}>
      ${map(this.findings, (problem) => this.renderRow(problem))}
    </ul>`;
  }

  private renderRow(problem: FindingShape): TemplateResult {
    const where = problem.where.replace(/^\$\.?/, "") || msg("the whole");
    const line = problem.line > 0 ? msg(str`${where} (line ${String(problem.line)})`) : where;
    return html`<li class=${problem.note ? "note" : ""}>
      ${this.places
        ? html`<button type="button" @click=${this.problemOpener(problem)}>${line}</button>`
        : html`<code>${line}</code>`}
      <div>${problem.note ? msg("Note: ") : ""}${problem.problem}${problem.remedy === "" ? "" : html`<span class="remedy"> — ${problem.remedy}</span>`}</div>
    </li>`;
  }

  private problemOpener(problem: FindingShape): () => void {
    return () => {
      this.dispatchEvent(new CustomEvent("t-place", { detail: problem }));
    };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-findings": DescriptionProblems;
  }
}
