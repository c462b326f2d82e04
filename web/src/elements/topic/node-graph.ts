/** Nodes and topics of a robot, drawn: boxes in columns, lines from who publishes to who hears. A press on a box draws what is around it. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, svg, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import type { GraphNodeShape } from "../../generated/api.js";
import { drawGraph, keyOf, searchGraph, type GraphBox, type GraphDrawing, type GraphLine } from "../../boards/node-graph.js";
import { base, plainList, quietText } from "../base/base-style.js";
import { control } from "../forms/input-style.js";
import "../forms/button.js";

const WIDE = 168;
const HIGH = 30;
const APART_X = 44;
const APART_Y = 18;
/** So far below the boxes goes a line that leads back. */
const BELOW = 34;
const EDGE = 6;
/** Letters that a box has room for. */
const LETTERS = 21;
/** A drawing is made smaller to fit, down to this part of its size; then it is moved about. */
const LEAST_PART = 0.85;
const MOST_FOUND = 12;

@customElement("t-node-graph")
export class NodeGraph extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        grid-template-rows: auto auto minmax(0, 1fr);
        gap: var(--t-space-2);
        block-size: 100%;
        min-block-size: 0;
      }
      .tools {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2);
      }
      input[type="search"] {
        flex: 1 1 8rem;
      }
      label {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-1);
        font-size: var(--t-size-s);
      }
      p {
        ${quietText}
      }
      ul {
        ${plainList}
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-1);
      }
      .drawing {
        overflow: auto;
        min-block-size: 8rem;
      }
      svg {
        display: block;
        block-size: auto;
        font-family: var(--t-mono);
        font-size: 12px;
      }
      rect {
        fill: var(--t-surface);
        stroke: var(--t-muted);
      }
      .topic rect {
        stroke-dasharray: 3 3;
      }
      .focus rect {
        stroke: var(--t-accent);
        stroke-width: 2.5;
      }
      text {
        fill: var(--t-text);
      }
      .topic text {
        fill: var(--t-muted);
      }
      path {
        fill: none;
        stroke: var(--t-muted);
        opacity: 0.55;
      }
      path.back {
        stroke-dasharray: 5 3;
      }
      path.lit {
        stroke: var(--t-accent);
        stroke-width: 1.8;
        opacity: 1;
      }
      g[role="button"] {
        cursor: pointer;
      }
      g[role="button"]:focus-visible {
        outline: none;
      }
      g[role="button"]:focus-visible rect,
      g[role="button"]:hover rect {
        stroke: var(--t-accent);
        stroke-width: 2.5;
      }
    `,
  ];

  @property({ attribute: false }) nodes: readonly GraphNodeShape[] = [];
  /** What is drawn around at first: a name of a node or a topic; empty for all. */
  @property() around = "";
  @state() private focused = "";
  @state() private words = "";
  @state() private plumbing = false;
  /** The box whose lines stand out. */
  @state() private pointed = "";

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("around")) this.focused = this.keyNamed(this.around);
  }

  override render(): TemplateResult {
    const around = this.focused === "" ? this.keyNamed(this.around) : this.focused;
    const drawing = drawGraph(this.nodes, around === "all" ? "" : around, this.plumbing);
    const name = around.replace(/^\w+ /, "");
    return html`<div class="tools">
        <input type="search" aria-label=${msg("Search nodes and topics")} placeholder=${msg("Search")} .value=${this.words} @input=${this.onSearch} />
        <label><input type="checkbox" .checked=${this.plumbing} @change=${this.onPlumbing} /> ${msg("Logs and clocks, too")}</label>
        ${around === "" || around === "all" ? nothing : html`<t-button kind="quiet" @click=${this.showAll}>${msg("Show all")}</t-button>`}
      </div>
      ${this.words.trim() === "" ? html`<p role="status">${summaryOf(drawing, this.nodes.length, around === "all" ? "" : name)}</p>` : this.renderFound()}
      <div class="drawing" tabindex="0" role="group" aria-label=${msg("Nodes and topics, from who publishes to who hears")}>${this.renderDrawing(drawing, around)}</div>`;
  }

  private renderFound(): TemplateResult {
    const found = searchGraph(this.nodes, this.words);
    return html`<ul aria-label=${msg("Found")}>
      ${repeat(
        found.slice(0, MOST_FOUND),
        ({ key }) => key,
        ({ key, kind, name }) => html`<li><t-button kind="quiet" @click=${this.focuser(key)}>${name} <small>${kind}</small></t-button></li>`,
      )}
      ${found.length > MOST_FOUND ? html`<li><p>${msg(str`and ${String(found.length - MOST_FOUND)} more`)}</p></li>` : nothing}
      ${found.length === 0 ? html`<li><p>${msg("Nothing is called so.")}</p></li>` : nothing}
    </ul>`;
  }

  private renderDrawing({ boxes, lines, columns, rows }: GraphDrawing, around: string): TemplateResult {
    const place = new Map(boxes.map((box) => [box.key, box]));
    const width = columns * (WIDE + APART_X) - APART_X + 2 * EDGE;
    const height = rows * (HIGH + APART_Y) - APART_Y + 2 * EDGE + BELOW;
    const size = [Math.max(1, width), Math.max(1, height)].map(String).join(" ");
    return html`<svg viewBox=${`0 0 ${size}`} width=${Math.max(1, width)} .style=${`max-inline-size: max(100%, ${String(Math.round(width * LEAST_PART))}px)`} role="presentation">
      ${map(lines, (line) => this.renderLine(line, place))}
      ${repeat(
        boxes,
        ({ key }) => key,
        (box) => this.renderBox(box, box.key === around, lines),
      )}
    </svg>`;
  }

  private renderLine({ from, to }: GraphLine, place: ReadonlyMap<string, GraphBox>): unknown {
    const [a, b] = [place.get(from), place.get(to)];
    if (a === undefined || b === undefined) return nothing;
    const [x1, y1] = [leftOf(a) + WIDE, topOf(a) + HIGH / 2];
    const [x2, y2] = [leftOf(b), topOf(b) + HIGH / 2];
    const bend = Math.max(APART_X / 2, Math.abs(x2 - x1) / 3);
    const lit = this.pointed !== "" && (from === this.pointed || to === this.pointed);
    // What leads back, or stays in its column, goes below the boxes.
    const back = b.column <= a.column;
    const [below1, below2] = [y1 + HIGH / 2, y2 + HIGH / 2];
    const way = back
      ? [x1 - WIDE / 2, below1, x1 - WIDE / 2, below1 + BELOW, x2 + WIDE / 2, below2 + BELOW, x2 + WIDE / 2, below2]
      : [x1, y1, x1 + bend, y1, x2 - bend, y2, x2, y2];
    const [beginX, beginY, ...rest] = way.map(String);
    return svg`<path class=${`${back ? "back" : ""}${lit ? " lit" : ""}`} d=${`M${beginX ?? ""} ${beginY ?? ""}C${rest.join(" ")}`}></path>`;
  }

  private renderBox(box: GraphBox, focus: boolean, lines: readonly GraphLine[]): unknown {
    const { key, name, kind } = box;
    const point = (): void => {
      this.pointed = key;
    };
    const unpoint = (): void => {
      this.pointed = "";
    };
    const press = (event: KeyboardEvent): void => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      this.focuser(key)();
    };
    return svg`<g role="button" tabindex="0" class=${`${kind}${focus ? " focus" : ""}`} data-key=${key} aria-label=${wordsOf(box, lines)} aria-pressed=${focus ? "true" : "false"}
      @click=${this.focuser(key)} @keydown=${press} @mouseenter=${point} @mouseleave=${unpoint} @focus=${point} @blur=${unpoint}>
      <title>${name}</title>
      <rect x=${leftOf(box)} y=${topOf(box)} width=${WIDE} height=${HIGH} rx=${kind === "node" ? 4 : HIGH / 2}></rect>
      <text x=${leftOf(box) + 10} y=${topOf(box) + HIGH / 2 + 4}>${shortened(name)}</text>
    </g>`;
  }

  private keyNamed(name: string): string {
    if (name === "") return "";
    return keyOf(this.nodes.some((node) => node.name === name) ? "node" : "topic", name);
  }

  private focuser(key: string): () => void {
    return () => {
      this.focused = key;
      this.words = "";
      this.pointed = "";
    };
  }

  private readonly showAll = (): void => {
    this.focused = "all";
  };

  private readonly onSearch = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.words = event.target.value;
  };

  private readonly onPlumbing = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.plumbing = event.target.checked;
  };
}

function leftOf({ column }: GraphBox): number {
  return EDGE + column * (WIDE + APART_X);
}

function topOf({ row }: GraphBox): number {
  return EDGE + row * (HIGH + APART_Y);
}

/** Names that are cut keep their end, by which they differ. */
function shortened(name: string): string {
  return name.length > LETTERS ? `…${name.slice(1 - LETTERS)}` : name;
}

function wordsOf({ key, name, kind }: GraphBox, lines: readonly GraphLine[]): string {
  const after = lines.filter(({ from }) => from === key).map(({ to }) => to.replace(/^\w+ /, ""));
  const before = lines.filter(({ to }) => to === key).map(({ from }) => from.replace(/^\w+ /, ""));
  const [to, from] = [after.join(", "), before.join(", ")];
  const said = kind === "node"
    ? [msg(str`Node ${name}.`), to && msg(str`Publishes ${to}.`), from && msg(str`Hears ${from}.`)]
    : [msg(str`Topic ${name}.`), from && msg(str`Comes from ${from}.`), to && msg(str`Goes to ${to}.`)];
  return said.filter((sentence) => sentence !== "").join(" ");
}

function summaryOf({ boxes, left }: GraphDrawing, nodes: number, around: string): string {
  const shown = around === "" ? msg(str`${String(nodes)} nodes`) : msg(str`Around ${around}`);
  return left > 0 ? msg(str`${shown}; the ${String(boxes.length)} boxes that are joined most are drawn, ${String(left)} are not. Search or press one to see what is around it.`) : msg(str`${shown}. Dashed lines lead back. A press on a box draws what is around it.`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-node-graph": NodeGraph;
  }
}
