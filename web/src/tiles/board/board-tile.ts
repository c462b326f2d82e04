/** One tile of a board: its head, what it shows, and in its place what keeps it from showing it. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { LoadController } from "../../controllers/load.js";
import { FrameSchedule } from "../../elements/base/frame-schedule.js";
import { base, raisedBox } from "../../elements/base/base-style.js";
import { adviceFor } from "../../format/error-advice.js";
import type { BoardTileShape } from "../../generated/api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/loading.js";
import { boardTileEntry } from "./board-catalog.js";
import type { BoardTileContext, BoardTileEntry } from "./board-tile-entry.js";
import { missingNames, tileTrouble, type TileTrouble } from "./tile-trouble.js";

/** What takes no longer is not worth a word, nor the elements for it in each tile. */
const LATE_MS = 250;

@customElement("t-board-tile")
export class BoardTile extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        grid-template-rows: auto minmax(0, 1fr);
        block-size: 100%;
        min-inline-size: 0;
        ${raisedBox}
        overflow: hidden;
        /* It has its size from the board: what changes in it moves nothing around it, and no other tile is laid out anew. */
        contain: strict;
      }
      :host([past]) {
        border-style: dashed;
        border-color: var(--t-accent);
      }
      header {
        display: flex;
        align-items: baseline;
        gap: var(--t-space-2);
        padding: var(--t-space-2) var(--t-space-3) 0;
        min-inline-size: 0;
      }
      h2 {
        overflow: hidden;
        color: var(--t-muted);
        font-size: var(--t-size-s);
        text-overflow: ellipsis;
        white-space: nowrap;
      }
      .missing {
        min-inline-size: 0;
        margin-inline-start: auto;
        overflow: hidden;
        color: var(--t-warn);
        font-size: var(--t-size-s);
        text-overflow: ellipsis;
        white-space: nowrap;
      }
      .inside {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        grid-template-rows: minmax(0, 1fr);
        padding: var(--t-space-2) var(--t-space-3) var(--t-space-3);
        min-block-size: 0;
        overflow: auto;
        overscroll-behavior: contain;
        /* What is only said to a screen reader stays inside; letters go by the tile's width. */
        position: relative;
        container-type: inline-size;
        --t-map-height: 8rem;
        --t-scene-around: var(--t-surface);
      }
      .inside:focus-visible {
        outline-offset: -3px;
      }
      .trouble {
        display: grid;
        align-content: center;
        justify-items: center;
        gap: var(--t-space-1);
        color: var(--t-muted);
        font-size: var(--t-size-s);
        text-align: center;
        overflow-wrap: anywhere;
      }
      .trouble strong {
        color: var(--t-text);
      }
      .trouble t-icon {
        font-size: 1.5rem;
      }
    `,
  ];

  @property({ attribute: false }) tile: BoardTileShape | null = null;
  @property({ attribute: false }) context: BoardTileContext | null = null;
  /** It shows a past moment, and looks like it. */
  @property({ type: Boolean, reflect: true }) past = false;
  /** The board is being arranged. */
  @property({ type: Boolean }) arranged = false;
  @query(".inside") private readonly inside!: HTMLElement | null;

  private readonly element = new LoadController<unknown>(this);
  /** To be measured once all tiles are drawn: in between, each would have the whole board laid out anew. */
  private readonly measuring = new FrameSchedule(() => {
    this.letScroll();
  });
  private readonly size = new ResizeObserver(this.measuring.schedule);
  /** It has been on its way for so long that it is said. */
  @state() private late = false;
  private lateTimer: ReturnType<typeof setTimeout> | undefined;

  override connectedCallback(): void {
    super.connectedCallback();
    this.size.observe(this);
    this.lateTimer = setTimeout(() => {
      if (this.element.result.state === "loading") this.late = true;
    }, LATE_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.size.disconnect();
    this.measuring.cancel();
    clearTimeout(this.lateTimer);
  }

  override willUpdate(): void {
    const entry = boardTileEntry(this.tile?.type ?? "");
    if (entry !== null) this.element.load(entry.type, entry.load);
  }

  override render(): TemplateResult | typeof nothing {
    const { tile, context } = this;
    if (tile === null || context === null) return nothing;
    const entry = boardTileEntry(tile.type);
    const title = tile.title || (entry === null ? tile.type : (entry.titleOf?.(tile.settings, context) ?? entry.title));
    return html`<header><h2 id="title" title=${title}>${title}</h2>${renderMissing(entry === null ? [] : missingNames(entry, tile.settings, context))}</header>
      <div class="inside" role="group" aria-labelledby="title">${this.renderInside(tile, entry, context)}</div>`;
  }

  override updated(): void {
    this.measuring.schedule();
  }

  private renderInside(tile: BoardTileShape, entry: BoardTileEntry | null, context: BoardTileContext): unknown {
    if (entry === null) {
      return html`<div class="trouble" data-state="error">
        <t-icon name="warn"></t-icon><strong>${msg(str`There is no tile “${tile.type}”`)}</strong>
        <span>${msg("This hub is older than the board, or its type is misspelt.")}</span>
      </div>`;
    }
    const trouble = tileTrouble(entry, tile.settings, context);
    if (trouble !== null) return renderTrouble(trouble);
    const { result } = this.element;
    if (result.state === "failed") return html`<div data-state="error">${renderAdvice(adviceFor(result.error, msg("the tile")), this.element.invalidate)}</div>`;
    if (result.state !== "ready") return !this.late ? nothing : html`<t-loading what=${msg("Loading the tile")}></t-loading>`;
    if (this.arranged && entry.rests === true) {
      return html`<div class="trouble"><t-icon name=${entry.icon}></t-icon><span>${msg(str`${entry.title}: at rest while the board is arranged.`)}</span></div>`;
    }
    if (context.past === null || entry.past === "moves") return entry.render(tile.settings, context);
    return entry.past === undefined ? renderNotKept(entry) : entry.past(tile.settings, context);
  }

  /** What is larger than the tile scrolls inside it, also by keyboard. */
  private letScroll(): void {
    const { inside } = this;
    if (inside === null) return;
    if (inside.scrollHeight > inside.clientHeight + 1 || inside.scrollWidth > inside.clientWidth + 1) inside.tabIndex = 0;
    else inside.removeAttribute("tabindex");
  }
}

/** Said beside the title: what is there is drawn all the same. */
function renderMissing(names: readonly string[]): TemplateResult | typeof nothing {
  if (names.length === 0) return nothing;
  const what = names.join(", ");
  return html`<span class="missing" title=${msg(str`There is no ${what} here, or your role may not see it.`)}>${msg(str`without ${what}`)}</span>`;
}

function renderNotKept({ notKept }: BoardTileEntry): TemplateResult {
  return html`<div class="trouble" data-state="past">
    <t-icon name="history"></t-icon><strong>${msg("Nothing was recorded at this moment")}</strong>${notKept === undefined ? nothing : html`<span>${notKept}</span>`}
  </div>`;
}

function renderTrouble({ kind, what }: TileTrouble): TemplateResult {
  if (kind === "empty") {
    return html`<div class="trouble" data-state="empty">
      <t-icon name="info"></t-icon><strong>${what}</strong><span>${msg("Its settings are behind Arrange.")}</span>
    </div>`;
  }
  return html`<div class="trouble" data-state="forbidden">
    <t-icon name="lock"></t-icon><strong>${msg("Not open to you")}</strong>
    <span>${msg(str`There is no ${what} here, or your role may not see it.`)}</span>
  </div>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-board-tile": BoardTile;
  }
}
