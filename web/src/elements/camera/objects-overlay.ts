/** Over a camera's picture: whether objects are framed, and how many are seen. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { countText } from "../../format/object-names.js";
import { base } from "../base/base-style.js";
import { onPicture } from "./picture-overlay.js";

export interface ObjectCount {
  readonly label: string;
  readonly many: number;
}

/**
 * - `waiting`: nothing has come since it was switched on
 * - `telling`: what is seen is known
 * - `silent`: nothing has come for a while
 */
export type DetectorState = "waiting" | "telling" | "silent";

/**
 * @fires t-objects-switch detail is whether objects are wanted
 * @fires t-objects-open detail is whether to choose what is framed
 */
@customElement("t-objects")
export class ObjectsOverlay extends LitElement {
  static override styles = [
    base,
    onPicture,
    css`
      :host {
        display: block;
        padding: var(--t-space-2);
        pointer-events: none;
      }
      .strip {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1);
        max-inline-size: 100%;
      }
      .strip > * {
        pointer-events: auto;
      }
      .key[aria-pressed="true"] {
        border-color: var(--t-accent);
        box-shadow: inset 0 0 0 1px var(--t-accent);
        color: var(--t-accent);
      }
      .counts {
        flex-wrap: wrap;
        gap: 0 var(--t-space-3);
        font-weight: var(--t-weight-strong);
      }
      .quiet {
        color: var(--t-muted);
        font-weight: var(--t-weight);
      }
      .silent {
        color: var(--t-warn);
      }
    `,
  ];

  @property({ type: Boolean }) on = false;
  @property() detector: DetectorState = "waiting";
  @property({ attribute: false }) counts: readonly ObjectCount[] = [];
  /** Where it stands why a detector says nothing; empty for whoever may not read it. */
  @property() why = "";
  /** Somebody drives by this picture: choosing waits. */
  @property({ type: Boolean }) busy = false;
  /** What is framed is being chosen. */
  @property({ type: Boolean }) open = false;

  @query(".choose") private readonly opener!: HTMLButtonElement | null;

  /** Back to the button that opened it. */
  override focus(): void {
    this.opener?.focus();
  }

  override render(): TemplateResult {
    return html`<div class="strip">
        <button type="button" class="key worded" aria-pressed=${this.on ? "true" : "false"} title=${msg("Show detected objects on the picture")} @click=${this.onSwitch}>
          ${renderIcon("M4 8V4h4M16 4h4v4M20 16v4h-4M8 20H4v-4M9 9h6v6H9z")} ${msg("Objects")}
        </button>
        ${this.on ? this.renderDetails() : nothing}
        ${this.on && !this.busy
          ? html`<button
              type="button"
              class="key worded choose"
              aria-label=${msg("Choose which objects are framed")}
              title=${msg("Choose which objects are framed")}
              aria-expanded=${this.open ? "true" : "false"}
              @click=${this.onToggle}
            >
              ${renderIcon("M4 7h9M17 7h3M15 5v4M4 17h3M11 17h9M9 15v4")}
            </button>`
          : nothing}
      </div>`;
  }

  /** Nobody who drives is led away. */
  private renderLogbookLink(): TemplateResult | typeof nothing {
    return this.why === "" || this.busy ? nothing : html`<a href=${this.why}>${msg("why?")}</a>`;
  }

  private renderDetails(): TemplateResult {
    if (this.detector === "waiting") return html`<span class="counts quiet">${msg("waiting for the detector")}${this.renderLogbookLink()}</span>`;
    if (this.detector === "silent") return html`<span class="counts silent">${msg("the detector is silent")}${this.renderLogbookLink()}</span>`;
    if (this.counts.length === 0) return html`<span class="counts quiet">${msg("nothing seen")}</span>`;
    return html`<span class="counts" role="group" aria-label=${msg("Seen now")}
      >${map(this.counts, ({ label, many }) => html`<span>${countText(many, label)}</span>`)}</span
    >`;
  }

  private readonly onSwitch = (): void => {
    this.dispatchEvent(new CustomEvent("t-objects-switch", { detail: !this.on }));
  };

  private readonly onToggle = (): void => {
    this.dispatchEvent(new CustomEvent("t-objects-open", { detail: !this.open }));
  };

}

function renderIcon(path: string): TemplateResult {
  return html`<svg viewBox="0 0 24 24" aria-hidden="true">
    <path d=${path} fill="none" stroke="currentColor" stroke-width="2" stroke-linecap="round" stroke-linejoin="round"></path>
  </svg>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-objects": ObjectsOverlay;
  }
  interface HTMLElementEventMap {
    "t-objects-switch": CustomEvent<boolean>;
    "t-objects-open": CustomEvent<boolean>;
  }
}
