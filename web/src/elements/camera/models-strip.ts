/** Over a camera's picture: which models' words are drawn on it, and what they say, as a legend. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../base/base-style.js";
import { styled } from "../base/style-directive.js";
import { onPicture } from "./picture-overlay.js";

/**
 * - `waiting`: nothing has come since it was switched on
 * - `telling`: what it sees is known
 * - `silent`: nothing has come for a while
 */
export type ModelState = "waiting" | "telling" | "silent";

/** One thing that a model says; with the colour that it has on the picture, 1 to 8, or 0 for none. */
export interface LegendWord {
  readonly text: string;
  readonly colour: number;
}

export interface ModelRow {
  readonly id: string;
  readonly on: boolean;
  readonly state: ModelState;
  readonly words: readonly LegendWord[];
}

/** More than these stand behind "and 3 more". */
const MOST_WORDS = 4;

/** @fires t-model-switch detail is the model that is to be drawn, or no more */
@customElement("t-models")
export class ModelsStrip extends LitElement {
  static override styles = [
    base,
    onPicture,
    css`
      :host {
        display: flex;
        flex-wrap: wrap;
        align-content: start;
        gap: var(--t-space-1) var(--t-space-2);
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
      .key[aria-pressed="true"] {
        border-color: var(--t-accent);
        box-shadow: inset 0 0 0 1px var(--t-accent);
        color: var(--t-accent);
      }
      .counts {
        flex-wrap: wrap;
        gap: 0 var(--t-space-3);
      }
      .word {
        display: inline-flex;
        align-items: center;
        gap: 0.4em;
        font-weight: var(--t-weight-strong);
      }
      .swatch {
        inline-size: 0.9em;
        block-size: 0.9em;
        border: 1px solid var(--t-text);
        border-radius: 2px;
      }
      .quiet {
        color: var(--t-muted);
      }
      .silent {
        color: var(--t-warn);
      }
    `,
  ];

  @property({ attribute: false }) models: readonly ModelRow[] = [];

  override render(): TemplateResult {
    return html`${map(
      this.models,
      ({ id, on, ...row }) => html`<div class="strip">
        <button
          type="button"
          class="key worded"
          aria-pressed=${on ? "true" : "false"}
          title=${msg(str`Draw what the model ${id} tells over the picture`)}
          data-model=${id}
          @click=${this.onSwitch}
        >
          <svg viewBox="0 0 24 24" aria-hidden="true">
            <path d="M12 4l8 4-8 4-8-4zM4 12l8 4 8-4M4 16l8 4 8-4" fill="none" stroke="currentColor" stroke-width="2" stroke-linecap="round" stroke-linejoin="round"></path>
          </svg>
          ${id}
        </button>
        ${on ? this.renderWords(id, row.state, row.words) : nothing}
      </div>`,
    )}`;
  }

  private renderWords(id: string, state: ModelState, words: readonly LegendWord[]): TemplateResult {
    if (state === "waiting") return html`<span class="counts quiet">${msg("waiting for the model")}</span>`;
    if (state === "silent") return html`<span class="counts silent">${msg("the model is silent")}</span>`;
    if (words.length === 0) return html`<span class="counts quiet">${msg("none of its classes")}</span>`;
    const more = words.length - MOST_WORDS;
    return html`<span class="counts" role="group" aria-label=${msg(str`What ${id} tells now`)}
      >${map(
        words.slice(0, MOST_WORDS),
        ({ text, colour }) => html`<span class="word">
          ${colour > 0 ? html`<span class="swatch" aria-hidden="true" ${styled({ background: `var(--t-series-${String(colour)})` })}></span>` : nothing}${text}
        </span>`,
      )}${more > 0 ? html`<span class="quiet">${msg(str`and ${more} more`)}</span>` : nothing}</span
    >`;
  }

  private readonly onSwitch = (event: Event): void => {
    const detail = (event.currentTarget as HTMLElement).dataset.model ?? "";
    this.dispatchEvent(new CustomEvent("t-model-switch", { detail }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-models": ModelsStrip;
  }
  interface HTMLElementEventMap {
    "t-model-switch": CustomEvent<string>;
  }
}
