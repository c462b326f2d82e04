/** A grid whose items a person arranges: by dragging, by their corner, and by keys. What stands in them is slotted. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { changeItem, COLUMNS, type GridItem, type GridName, type LeastSize } from "../../boards/grid.js";
import { base } from "../base/base-style.js";
import { styled } from "../base/style-directive.js";
import "../base/icon.js";

/** An item of the grid with what is said of it. */
export interface NamedItem extends GridItem {
  readonly name: string;
  readonly least: LeastSize;
}

interface DragState {
  readonly item: NamedItem;
  readonly resizes: boolean;
  readonly fromX: number;
  readonly fromY: number;
  readonly before: readonly GridItem[];
}

const STEPS: Readonly<Record<string, readonly [x: number, y: number]>> = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
};

/**
 * @slot <id> - what stands in the item of that id
 * @fires t-arrange the items as a person has put them; detail is the list
 * @fires t-settings the person asks for an item's settings; detail is its id
 * @fires t-remove the person takes an item away; detail is its id
 */
@customElement("t-board-grid")
export class BoardGrid extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        min-inline-size: 0;
      }
      .grid {
        position: relative;
        display: grid;
        grid-auto-rows: 4rem;
        gap: var(--t-space-3);
        grid-template-columns: repeat(var(--columns), minmax(0, 1fr));
      }
      .cell {
        position: relative;
        min-inline-size: 0;
        min-block-size: 0;
        grid-column: var(--x) / span var(--w);
        grid-row: var(--y) / span var(--h);
      }
      .editing .cell {
        outline: 2px dashed var(--t-edge);
        outline-offset: 1px;
        border-radius: var(--t-radius);
      }
      .moved {
        z-index: 2;
        opacity: 0.85;
      }
      .tools {
        position: absolute;
        inset-block-start: 0;
        inset-inline: 0;
        z-index: 3;
        display: flex;
        justify-content: space-between;
        pointer-events: none;
      }
      .tools > * {
        display: flex;
        pointer-events: auto;
      }
      button {
        display: grid;
        place-items: center;
        min-inline-size: 2.25rem;
        min-block-size: 2.25rem;
        padding: 0;
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
        cursor: pointer;
      }
      @media (pointer: coarse) {
        button {
          min-inline-size: var(--t-touch);
          min-block-size: var(--t-touch);
        }
      }
      .grip {
        cursor: grab;
        touch-action: none;
      }
      .corner {
        position: absolute;
        inset-block-end: 0;
        inset-inline-end: 0;
        z-index: 3;
        cursor: nwse-resize;
        touch-action: none;
      }
    `,
  ];

  @property({ attribute: false }) items: readonly NamedItem[] = [];
  @property() grid: GridName = "desktop";
  @property({ type: Boolean }) editing = false;
  @state() private draft: readonly GridItem[] | null = null;
  @state() private spoken = "";
  @query(".grid") private readonly place!: HTMLElement;
  private drag: DragState | null = null;

  override render(): TemplateResult {
    const shown = new Map((this.draft ?? this.items).map((item) => [item.id, item]));
    return html`<div class="grid ${this.editing ? "editing" : ""}" ${styled({ "--columns": String(COLUMNS[this.grid]) })}>
        ${repeat(
          this.items,
          ({ id }) => id,
          (item) => this.renderCell(item, shown.get(item.id) ?? item),
        )}
      </div>
      <p class="visually-hidden" aria-live="polite">${this.spoken}</p>`;
  }

  private renderCell(item: NamedItem, { x, y, w, h }: GridItem): TemplateResult {
    const place = { "--x": String(x + 1), "--y": String(y + 1), "--w": String(w), "--h": String(h) };
    const moved = this.drag?.item.id === item.id && this.draft !== null;
    return html`<div class="cell ${moved ? "moved" : ""}" data-id=${item.id} ${styled(place)}>
      ${this.editing ? this.renderTools(item) : nothing}
      <slot name=${item.id}></slot>
      ${this.editing
        ? html`<button class="corner" type="button" tabindex="-1" aria-hidden="true" @pointerdown=${this.dragStarter(item, true)}><t-icon name="down"></t-icon></button>`
        : nothing}
    </div>`;
  }

  private renderTools(item: NamedItem): TemplateResult {
    return html`<div class="tools">
      <button
        class="grip"
        type="button"
        aria-label=${msg(str`Move ${item.name}: arrow keys move it, with Shift they change its size, Delete takes it away`)}
        @pointerdown=${this.dragStarter(item, false)}
        @keydown=${this.keyListener(item)}
      ><t-icon name="drive"></t-icon></button>
      <span>
        <button type="button" aria-label=${msg(str`Settings of ${item.name}`)} @click=${this.firer("t-settings", item.id)}><t-icon name="info"></t-icon></button>
        <button type="button" aria-label=${msg(str`Take ${item.name} away`)} @click=${this.firer("t-remove", item.id)}><t-icon name="close"></t-icon></button>
      </span>
    </div>`;
  }

  private dragStarter(item: NamedItem, resizes: boolean): (event: PointerEvent) => void {
    return (event) => {
      this.beginDrag(event, item, resizes);
    };
  }

  private keyListener(item: NamedItem): (event: KeyboardEvent) => void {
    return (event) => {
      this.onKeyDown(event, item);
    };
  }

  private firer(kind: string, id: string): () => void {
    return () => {
      this.fire(kind, id);
    };
  }

  private onKeyDown(event: KeyboardEvent, item: NamedItem): void {
    if (event.key === "Delete" || event.key === "Backspace") {
      event.preventDefault();
      this.fire("t-remove", item.id);
      return;
    }
    const step = STEPS[event.key];
    if (step === undefined) return;
    event.preventDefault();
    const [dx, dy] = step;
    const wish = event.shiftKey ? { ...item, w: item.w + dx, h: item.h + dy } : { ...item, x: item.x + dx, y: item.y + dy };
    const items = this.arranged(wish, item.least, this.items, !event.shiftKey && dy > 0);
    const now = items.find(({ id }) => id === item.id);
    if (now !== undefined) {
      this.spoken = event.shiftKey
        ? msg(str`${item.name}: ${String(now.w)} columns wide, ${String(now.h)} rows high`)
        : msg(str`${item.name}: column ${String(now.x + 1)}, row ${String(now.y + 1)}`);
    }
    this.fire("t-arrange", items);
  }

  /** A step down jumps over what stands below: one row would settle back to where it was. */
  private arranged(wish: GridItem, least: LeastSize, before: readonly GridItem[], down: boolean): readonly GridItem[] {
    const columns = COLUMNS[this.grid];
    const once = changeItem(before, wish, columns, least);
    const old = before.find(({ id }) => id === wish.id);
    if (!down || old === undefined || once.some(({ id, y }) => id === wish.id && y > old.y)) return once;
    const below = before.filter(({ id, x, w, y }) => id !== wish.id && y >= old.y + old.h && x < old.x + old.w && old.x < x + w);
    const next = Math.min(...below.map(({ y, h }) => y + h));
    return Number.isFinite(next) ? changeItem(before, { ...wish, y: next }, columns, least) : once;
  }

  private beginDrag(event: PointerEvent, item: NamedItem, resizes: boolean): void {
    if (event.button !== 0 || !(event.currentTarget instanceof HTMLElement)) return;
    event.preventDefault();
    event.currentTarget.focus();
    this.drag = { item, resizes, fromX: event.clientX, fromY: event.clientY, before: this.items };
    window.addEventListener("pointermove", this.onPointerMove);
    window.addEventListener("pointerup", this.onPointerUp);
    window.addEventListener("pointercancel", this.onPointerCancel);
  }

  private readonly onPointerMove = (event: PointerEvent): void => {
    const { drag } = this;
    if (drag === null) return;
    const columns = COLUMNS[this.grid];
    const gap = Number.parseFloat(getComputedStyle(this.place).columnGap) || 0;
    const cell = (this.place.clientWidth + gap) / columns;
    const row = 4 * Number.parseFloat(getComputedStyle(document.documentElement).fontSize) + gap;
    const dx = Math.round((event.clientX - drag.fromX) / cell);
    const dy = Math.round((event.clientY - drag.fromY) / row);
    const { item } = drag;
    const wish = drag.resizes ? { ...item, w: item.w + dx, h: item.h + dy } : { ...item, x: item.x + dx, y: item.y + dy };
    this.draft = changeItem(drag.before, wish, columns, item.least);
  };

  private readonly onPointerUp = (): void => {
    const items = this.draft;
    this.endDrag();
    if (items !== null) this.fire("t-arrange", items);
  };

  private readonly onPointerCancel = (): void => {
    this.endDrag();
  };

  private endDrag(): void {
    this.drag = null;
    this.draft = null;
    window.removeEventListener("pointermove", this.onPointerMove);
    window.removeEventListener("pointerup", this.onPointerUp);
    window.removeEventListener("pointercancel", this.onPointerCancel);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.endDrag();
  }

  private fire(kind: string, detail: unknown): void {
    this.dispatchEvent(new CustomEvent(kind, { detail }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-board-grid": BoardGrid;
  }
}
