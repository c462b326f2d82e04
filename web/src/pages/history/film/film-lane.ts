/** Where in the window there are films: one row for each camera, in line with the charts. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../../elements/base/base-style.js";
import type { ChartIndent } from "../../../elements/chart/chart-model.js";
import { styled } from "../../../elements/base/style-directive.js";
import { lengthOf, type TimeSpan } from "../../../series/time-window.js";
import type { CameraFilms } from "../../../state/past/film-search.js";

/** Narrower than this part of the window a film could not be hit. */
const LEAST_PART = 0.004;

/** @fires t-moment detail is a moment (µs) to go to */
@customElement("t-film-lane")
export class FilmLane extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: 2px;
        padding-inline: var(--t-space-1);
        min-inline-size: 0;
      }
      .row {
        position: relative;
        block-size: 1.5rem;
        border-radius: var(--t-radius-s);
        background: var(--t-raised);
        overflow: hidden;
        cursor: pointer;
      }
      .film {
        position: absolute;
        inset-block: 0;
        background: color-mix(in srgb, var(--t-accent) 35%, transparent);
        border-inline: 2px solid var(--t-accent);
      }
      .film.coming,
      .film.raw {
        background: repeating-linear-gradient(-45deg, var(--t-line) 0 4px, transparent 4px 8px);
        border-color: var(--t-edge);
      }
      .at {
        position: absolute;
        inset-block: 0;
        inline-size: 2px;
        margin-inline-start: -1px;
        background: var(--t-text);
      }
      .name {
        position: absolute;
        inset-inline-start: var(--t-space-2);
        inset-block: 0;
        align-content: center;
        font-size: var(--t-size-s);
        pointer-events: none;
        text-shadow: 0 0 3px var(--t-raised), 0 0 3px var(--t-raised);
      }
    `,
  ];

  @property({ attribute: false }) reels: readonly CameraFilms[] = [];
  @property({ attribute: false }) span: TimeSpan = { fromUs: 0, toUs: 1 };
  @property({ attribute: false }) indent: ChartIndent = { left: 0, right: 0 };
  @property({ type: Number }) us = 0;

  override render(): unknown {
    const at = (this.us - this.span.fromUs) / lengthOf(this.span);
    const room = { "margin-inline": `${String(this.indent.left)}px ${String(this.indent.right)}px` };
    // The buttons of each view lead to the same moments: this is for eyes and pointers.
    return this.reels.map(
      (reel) => html`<div class="row" aria-hidden="true" ${styled(room)} @click=${this.onClick}>
        ${map(reel.films, (film) => this.renderBar(film.begin_us, film.end_us, film.state === "complete" ? "" : "coming"))}
        ${map(reel.unfilmed, (stretch) => this.renderBar(stretch.begin_us, stretch.end_us, "raw"))}
        ${at < 0 || at > 1 ? nothing : html`<div class="at" ${styled({ "inset-inline-start": `${String(100 * at)}%` })}></div>`}
        <span class="name">${reel.name}</span>
      </div>`,
    );
  }

  private renderBar(fromUs: number, toUs: number, kind: string): TemplateResult {
    const part = (us: number): number => Math.min(1, Math.max(0, (us - this.span.fromUs) / lengthOf(this.span)));
    const wide = Math.max(LEAST_PART, part(toUs) - part(fromUs));
    return html`<div class="film ${kind}" ${styled({ "inset-inline-start": `${String(100 * part(fromUs))}%`, "inline-size": `${String(100 * wide)}%` })}></div>`;
  }

  private readonly onClick = (event: MouseEvent): void => {
    if (!(event.currentTarget instanceof HTMLElement)) return;
    const box = event.currentTarget.getBoundingClientRect();
    const us = this.span.fromUs + ((event.clientX - box.left) / Math.max(1, box.width)) * lengthOf(this.span);
    this.dispatchEvent(new CustomEvent("t-moment", { detail: us, bubbles: true, composed: true }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-film-lane": FilmLane;
  }
}
