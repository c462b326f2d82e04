import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base, plainList } from "../../elements/base/base-style.js";
import { differenceLines, differenceText, type DifferenceLine } from "../../format/unified-diff.js";
import type { DifferenceShape } from "../../generated/api.js";

const KINDS: Readonly<Record<DifferenceShape["kind"], string>> = {
  added: msg("+ added"),
  removed: msg("\u2212 removed"),
  changed: msg("≠ changed"),
  renamed: msg("→ renamed"),
};

/** Two descriptions held against each other: the parts in words, the lines with signs and colours. */
@customElement("t-difference")
export class DescriptionDiff extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
      }
      ul {
        display: grid;
        gap: var(--t-space-2);
        ${plainList}
      }
      li {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-3);
        overflow-wrap: anywhere;
      }
      .kind {
        min-inline-size: 6.5rem;
        font-weight: var(--t-weight-strong);
      }
      .added .kind,
      .added .sign {
        color: var(--t-ok);
      }
      .removed .kind,
      .removed .sign {
        color: var(--t-bad);
      }
      .lines {
        max-block-size: 32rem;
        overflow: auto;
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
        line-height: 1.5;
      }
      .lines:focus-visible {
        outline: 3px solid var(--t-accent);
      }
      .line {
        display: grid;
        grid-template-columns: 3.5rem 1.5rem minmax(max-content, 1fr);
        inline-size: max-content;
        min-inline-size: 100%;
        white-space: pre;
      }
      .line.added {
        background: color-mix(in srgb, var(--t-ok) 12%, transparent);
      }
      .line.removed {
        background: color-mix(in srgb, var(--t-bad) 12%, transparent);
      }
      .line.place {
        background: var(--t-raised);
        color: var(--t-muted);
      }
      .number {
        padding-inline-end: var(--t-space-2);
        color: var(--t-muted);
        text-align: end;
        user-select: none;
      }
      .sign {
        font-weight: var(--t-weight-strong);
        text-align: center;
      }
    `,
  ];

  @property({ attribute: false }) parts: readonly DifferenceShape[] = [];
  @property({ attribute: false }) lines: readonly string[] = [];

  override render(): TemplateResult {
    const lines = differenceLines(this.lines);
    if (lines.length === 0) return html`<p class="muted small">${msg("They say the same.")}</p>`;
    return html`${this.parts.length === 0
        ? nothing
        : html`<ul aria-label=${msg("What differs")}>
            ${map(this.parts, (part) => this.renderPart(part))}
          </ul>`}
      <p class="muted small">${differenceText(lines)}</p>
      <div class="lines" role="region" tabindex="0" aria-label=${msg("The lines that differ")}>${map(lines, (line) => this.renderLine(line))}</div>`;
  }

  private renderPart(part: DifferenceShape): TemplateResult {
    const from = part.kind === "added" ? "" : part.before;
    const to = part.kind === "removed" ? "" : part.after;
    const arrow = from !== "" && to !== "" ? " → " : "";
    return html`<li class=${part.kind}>
      <span class="kind">${KINDS[part.kind]}</span><code>${part.path.replace(/^\$\./, "")}</code
      ><span class="muted small">${from}${arrow}${to}</span>
    </li>`;
  }

  private renderLine(line: DifferenceLine): TemplateResult {
    const spoken = line.kind === "added" || line.kind === "removed" ? line.kind : nothing;
    return html`<div class=${`line ${line.kind}`}>
      <span class="number" aria-hidden="true">${line.after || line.before || ""}</span
      ><span class="sign" role=${spoken === nothing ? nothing : "img"} aria-label=${spoken}>${line.sign}</span
      ><span>${line.text}</span>
    </div>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-difference": DescriptionDiff;
  }
}
