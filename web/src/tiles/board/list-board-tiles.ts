/** Tiles that are lists: signals with their values, and words with links. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { linksOf } from "../../boards/tile-settings.js";
import { base, plainList } from "../../elements/base/base-style.js";
import type { SignalShape } from "../../generated/api.js";
import "../signal-value.js";
import type { BoardTileContext } from "./board-tile-entry.js";

const rows = css`
  :host {
    display: grid;
    align-content: start;
    gap: var(--t-space-2);
    min-inline-size: 0;
  }
  ul {
    ${plainList}
  }
`;

@customElement("t-tile-table")
export class TableBoardTile extends LitElement {
  static override styles = [
    base,
    rows,
    css`
      dl {
        margin: 0;
      }
      dl > div {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        justify-content: space-between;
        gap: 0 var(--t-space-3);
        padding-block: var(--t-space-1);
        border-block-start: 1px solid var(--t-line);
      }
      dl > div:first-child {
        border-block-start: 0;
      }
      dt {
        color: var(--t-muted);
        font-size: var(--t-size-s);
        overflow-wrap: anywhere;
      }
      dd {
        margin: 0;
        margin-inline-start: auto;
        --t-value-align: end;
      }
      p {
        color: var(--t-muted);
      }
    `,
  ];

  @property({ attribute: false }) context: BoardTileContext | null = null;
  @property({ attribute: false }) signals: readonly SignalShape[] = [];

  override render(): TemplateResult {
    const { signals } = this;
    if (signals.length === 0) return html`<p>${msg("No signal is chosen, or none is open to you.")}</p>`;
    return html`<dl>
      ${repeat(
        signals,
        ({ address }) => address,
        (signal) => html`<div>
          <dt>${signal.name}</dt>
          <dd><t-signal-value bare size="s" .site=${this.context?.site ?? ""} .signal=${signal}></t-signal-value></dd>
        </div>`,
      )}
    </dl>`;
  }
}

@customElement("t-tile-text")
export class TextBoardTile extends LitElement {
  static override styles = [
    base,
    rows,
    css`
      p {
        white-space: pre-wrap;
        overflow-wrap: anywhere;
      }
      a {
        display: inline-flex;
        align-items: center;
        min-block-size: 1.75rem;
        overflow-wrap: anywhere;
      }
    `,
  ];

  @property({ attribute: false }) lines: readonly string[] = [];
  @property({ attribute: false }) links: readonly string[] = [];

  override render(): TemplateResult {
    const links = linksOf(this.links);
    if (this.lines.length === 0 && links.length === 0) return html`<p class="muted">${msg("No words yet.")}</p>`;
    return html`${this.lines.length === 0 ? nothing : html`<p>${this.lines.join("\n")}</p>`}
      ${links.length === 0
        ? nothing
        : html`<ul>
            ${map(links, ({ label, href }) => html`<li>${href.startsWith("/") ? html`<a href=${href}>${label}</a>` : html`<a href=${href} target="_blank" rel="noopener noreferrer">${label}</a>`}</li>`)}
          </ul>`}`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-table": TableBoardTile;
    "t-tile-text": TextBoardTile;
  }
}
