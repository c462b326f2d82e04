import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { base, plainList, quietText } from "../base/base-style.js";
import { childrenOf, matchingPaths, valueNote, valueText, type TreeChild } from "../../topics/topic-tree.js";
import "../base/icon.js";

/** Opened by themselves: down to here, and only what has few parts. */
const OPEN_DEPTH = 2;
const FEW = 12;
/** Parts of one value that are drawn before somebody asks for all. */
const MOST_SHOWN = 100;

export interface FieldChoice {
  readonly path: string;
  /** It holds words, no number. */
  readonly text: boolean;
}

/**
 * A message as a tree of its fields, each to open and close.
 *
 * @fires t-plot detail: the path of a field whose numbers are to be drawn over time, or no more
 * @fires t-make-signal detail: the field that is to become a signal, a `FieldChoice`
 */
@customElement("t-message-tree")
export class MessageTree extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        min-inline-size: 0;
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
      }
      ul {
        ${plainList}
      }
      ul ul {
        padding-inline-start: var(--t-space-4);
        border-inline-start: 1px solid var(--t-line);
        margin-inline-start: 0.45rem;
      }
      .line {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-2);
        align-items: baseline;
        padding-block: 0.2rem;
        padding-inline-start: 1.4rem;
      }
      button {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-1);
        min-block-size: 1.75rem;
        padding: 0 var(--t-space-1) 0 0;
        border: 0;
        background: none;
        color: inherit;
        font: inherit;
        text-align: start;
        cursor: pointer;
      }
      button t-icon {
        rotate: -90deg;
        font-size: 1.1rem;
      }
      button[aria-expanded="true"] t-icon {
        rotate: none;
      }
      .plot,
      .signal {
        padding-inline: var(--t-space-2);
        color: var(--t-accent);
      }
      .plot[aria-pressed="true"] {
        font-weight: var(--t-weight-strong);
      }
      .all {
        padding-inline-start: 1.4rem;
        color: var(--t-accent);
      }
      .name {
        color: var(--t-muted);
      }
      .value {
        overflow-wrap: anywhere;
        white-space: pre-wrap;
      }
      .note {
        ${quietText}
        font-family: var(--t-font);
      }
      mark {
        background: none;
        color: var(--t-accent);
        font-weight: var(--t-weight-strong);
      }
      @media (pointer: coarse) {
        button {
          min-block-size: var(--t-touch);
        }
      }
    `,
  ];

  /** What the hub read of a message. */
  @property({ attribute: false }) value: unknown;
  /** Only what has this in its path is shown, and what leads there. */
  @property() search = "";

  /** Fields that are drawn over time; null where that is not offered. */
  @property({ attribute: false }) plotted: readonly string[] | null = null;

  /** Offer to make a field a signal of the site. */
  @property({ type: Boolean }) signals = false;

  /** What somebody has opened or closed, by path. */
  @state() private chosen: ReadonlyMap<string, boolean> = new Map();
  /** Of which all parts are shown. */
  @state() private whole: ReadonlySet<string> = new Set();
  private found: ReadonlySet<string> | null = null;

  protected override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("value") || changed.has("search")) this.found = matchingPaths(this.value, this.search);
  }

  override render(): TemplateResult {
    const children = childrenOf(this.value, "");
    if (children === null) return html`<p class="note">${msg("The message has no fields.")}</p>`;
    if (this.found?.size === 0) return html`<p class="note" role="status">${msg(str`No field is called “${this.search.trim()}”.`)}</p>`;
    return this.renderChildren(children, "", 0);
  }

  private renderChildren(children: readonly TreeChild[], path: string, depth: number): TemplateResult {
    const wanted = this.found === null || path !== "" && !this.leadsTo(children) ? children : children.filter((child) => this.found?.has(child.path) ?? true);
    const shown = this.whole.has(path) ? wanted : wanted.slice(0, MOST_SHOWN);
    return html`<ul>
      ${repeat(
        shown,
        (child) => child.path,
        (child) => this.renderChild(child, depth),
      )}
      ${shown.length === wanted.length ? nothing : html`<li><button class="all" data-path=${path} @click=${this.showAll}>${msg(str`Show all ${String(wanted.length)}`)}</button></li>`}
    </ul>`;
  }

  /** Whether something below is what is searched for; below a match everything is shown. */
  private leadsTo(children: readonly TreeChild[]): boolean {
    return children.some((child) => this.found?.has(child.path) === true);
  }

  private renderChild({ name, path, value }: TreeChild, depth: number): TemplateResult {
    const children = childrenOf(value, path);
    const note = valueNote(value);
    const label = html`<span class="name" title=${path}>${this.found?.has(path) === true && this.isMatch(path) ? html`<mark>${name}</mark>` : name}</span>`;
    if (children === null) {
      return html`<li data-path=${path}>
        <div class="line">${label} <span class="value">${valueText(value)}</span>${note === "" ? nothing : html` <span class="note">${note}</span>`}${this.renderPlot(path, value)}${this.renderMakeSignal(path, value)}</div>
      </li>`;
    }
    const open = this.isOpen(path, children, depth);
    return html`<li data-path=${path}>
      <button aria-expanded=${open} data-path=${path} @click=${this.toggle}><t-icon name="down"></t-icon>${label}${note === "" ? nothing : html`<span class="note">${note}</span>`}</button>
      ${open ? this.renderChildren(children, path, depth + 1) : nothing}
    </li>`;
  }

  private renderPlot(path: string, value: unknown): TemplateResult | typeof nothing {
    if (this.plotted === null || (typeof value !== "number" && typeof value !== "boolean")) return nothing;
    return html`<button class="plot" aria-pressed=${this.plotted.includes(path)} aria-label=${msg(str`Plot ${path}`)} data-path=${path} @click=${this.onPlot}>${msg("plot")}</button>`;
  }

  private renderMakeSignal(path: string, value: unknown): TemplateResult | typeof nothing {
    if (!this.signals || !["number", "boolean", "string"].includes(typeof value)) return nothing;
    const choose = (): void => {
      const detail: FieldChoice = { path, text: typeof value === "string" };
      this.dispatchEvent(new CustomEvent("t-make-signal", { detail }));
    };
    return html`<button class="signal" aria-label=${msg(str`Make ${path} a signal`)} @click=${choose}>${msg("make a signal")}</button>`;
  }

  private isMatch(path: string): boolean {
    return path.toLowerCase().includes(this.search.trim().toLowerCase());
  }

  private isOpen(path: string, children: readonly TreeChild[], depth: number): boolean {
    const chosen = this.chosen.get(path);
    if (chosen !== undefined) return chosen;
    if (this.found !== null) return this.leadsTo(children);
    return depth < OPEN_DEPTH && children.length <= FEW;
  }

  private readonly toggle = (event: Event): void => {
    const button = event.currentTarget;
    if (!(button instanceof HTMLElement)) return;
    const open = button.getAttribute("aria-expanded") === "true";
    this.chosen = new Map([...this.chosen, [button.dataset["path"] ?? "", !open]]);
  };

  private readonly onPlot = (event: Event): void => {
    if (event.currentTarget instanceof HTMLElement) this.dispatchEvent(new CustomEvent("t-plot", { detail: event.currentTarget.dataset["path"] ?? "" }));
  };

  private readonly showAll = (event: Event): void => {
    if (event.currentTarget instanceof HTMLElement) this.whole = new Set([...this.whole, event.currentTarget.dataset["path"] ?? ""]);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-message-tree": MessageTree;
  }
}
