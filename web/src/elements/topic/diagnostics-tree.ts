import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { base, plainList, quietText } from "../base/base-style.js";
import { control } from "../forms/input-style.js";
import { formatAge } from "../../format/duration.js";
import { nodeMatches, type DiagnosticLevel, type DiagnosticNode, type DiagnosticStatus } from "../../series/diagnostics.js";
import type { StatusKind } from "../feedback/status.js";
import "../base/icon.js";
import "../feedback/empty.js";
import "../feedback/status.js";
import "../forms/button.js";

const KINDS: Readonly<Record<DiagnosticLevel, StatusKind>> = { ok: "ok", warn: "warn", stale: "stale", error: "bad" };
const WORDS: Readonly<Record<DiagnosticLevel, string>> = { ok: "OK", warn: "WARN", stale: "STALE", error: "ERROR" };
/** The gravest first. */
const ORDER: readonly DiagnosticLevel[] = ["error", "stale", "warn", "ok"];

/** A robot's diagnostics: each part with its level, what it says and its values. */
@customElement("t-diagnostics")
export class DiagnosticsTree extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      .tools,
      .counts {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-4);
      }
      .tools input {
        flex: 1 1 9rem;
      }
      ul {
        ${plainList}
      }
      ul ul {
        padding-inline-start: var(--t-space-4);
      }
      li {
        border-block-start: 1px solid var(--t-line);
      }
      .top > li:first-child {
        border-block-start: 0;
      }
      button {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr) auto;
        align-items: center;
        gap: var(--t-space-2);
        inline-size: 100%;
        min-block-size: var(--t-touch);
        padding: var(--t-space-1) 0;
        border: 0;
        background: none;
        color: inherit;
        font: inherit;
        text-align: start;
        cursor: pointer;
      }
      button t-icon {
        rotate: -90deg;
      }
      button[aria-expanded="true"] t-icon {
        rotate: none;
      }
      .name {
        font-weight: var(--t-weight-strong);
        overflow-wrap: anywhere;
      }
      .says {
        display: block;
        ${quietText}
        font-weight: var(--t-weight);
        overflow-wrap: anywhere;
      }
      dl {
        display: grid;
        grid-template-columns: minmax(6rem, max-content) minmax(0, 1fr);
        gap: var(--t-space-1) var(--t-space-4);
        margin: 0 0 var(--t-space-3) 1.75rem;
        font-size: var(--t-size-s);
      }
      dt {
        color: var(--t-muted);
        overflow-wrap: anywhere;
      }
      dd {
        margin: 0;
        overflow-wrap: anywhere;
        font-variant-numeric: tabular-nums;
      }
      @media (max-width: 45rem) {
        dl {
          grid-template-columns: minmax(0, 1fr);
          gap: 0;
        }
        dd {
          margin-block-end: var(--t-space-2);
        }
      }
    `,
  ];

  /** All of it as it stands now; null before the first message. */
  @property({ attribute: false }) root: DiagnosticNode | null = null;
  /** Statuses of the newest message that were too many to be shown. */
  @property({ type: Number }) left = 0;

  @state() private search = "";
  @state() private onlyProblems = false;
  /** What somebody has opened or closed, by path. */
  @state() private chosen: ReadonlyMap<string, boolean> = new Map();

  override render(): TemplateResult | typeof nothing {
    const { root } = this;
    if (root === null) return nothing;
    if (root.children.length === 0) {
      return html`<t-empty heading=${msg("No diagnostics")} icon="info"><p>${msg("The robot's messages hold no status yet.")}</p></t-empty>`;
    }
    const shown = root.children.filter((node) => this.isShown(node));
    return html`
      <div class="counts">${map(ORDER.filter((level) => root.counts[level] > 0), (level) => html`<t-status kind=${KINDS[level]} word=${`${String(root.counts[level])} ${WORDS[level]}`}></t-status>`)}</div>
      <div class="tools">
        <input type="search" aria-label=${msg("Search diagnostics")} placeholder=${msg("Name or message")} .value=${this.search} @input=${this.onSearch} />
        <t-button pressed=${this.onlyProblems ? "true" : "false"} @click=${this.toggleProblems}>${msg("Only problems")}</t-button>
      </div>
      ${this.left > 0 ? html`<p class="says">${msg(str`${String(this.left)} more are in the newest message than can be shown.`)}</p>` : nothing}
      ${shown.length === 0
        ? html`<p class="says" role="status">${this.onlyProblems && this.search === "" ? msg("Everything is OK.") : msg("Nothing matches.")}</p>`
        : this.renderNodes(shown, true)}
    `;
  }

  private renderNodes(nodes: readonly DiagnosticNode[], top = false): TemplateResult {
    return html`<ul class=${top ? "top" : ""}>
      ${repeat(
        nodes,
        ({ path }) => path,
        (node) => this.renderNode(node),
      )}
    </ul>`;
  }

  private renderNode(node: DiagnosticNode): TemplateResult {
    const open = this.isOpen(node);
    const says = node.status?.message ?? "";
    return html`<li data-path=${node.path} data-level=${node.level}>
      <button aria-expanded=${open} data-path=${node.path} @click=${this.toggle}>
        <t-icon name="down"></t-icon>
        <span class="name">${node.name}${says === "" ? nothing : html`<span class="says">${says}</span>`}</span>
        <t-status kind=${KINDS[node.level]} word=${WORDS[node.level]}></t-status>
      </button>
      ${open ? html`${node.status === null ? nothing : renderValues(node.status)}${node.children.length === 0 ? nothing : this.renderNodes(node.children.filter((child) => this.isShown(child)))}` : nothing}
    </li>`;
  }

  private isShown(node: DiagnosticNode): boolean {
    return (!this.onlyProblems || node.level !== "ok") && (this.search === "" || nodeMatches(node, this.search));
  }

  /** What is in trouble is opened by itself down to where the trouble is, and so is what is searched for. */
  private isOpen(node: DiagnosticNode): boolean {
    const chosen = this.chosen.get(node.path);
    if (chosen !== undefined) return chosen;
    return node.children.length > 0 && (node.level !== "ok" || this.search !== "");
  }

  private readonly toggle = (event: Event): void => {
    const button = event.currentTarget;
    if (!(button instanceof HTMLElement)) return;
    const open = button.getAttribute("aria-expanded") === "true";
    this.chosen = new Map([...this.chosen, [button.dataset["path"] ?? "", !open]]);
  };

  private readonly toggleProblems = (): void => {
    this.onlyProblems = !this.onlyProblems;
  };

  private readonly onSearch = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.search = event.target.value.trim();
  };
}

function renderValues(status: DiagnosticStatus): TemplateResult {
  return html`<dl>
    ${map(status.values, ([key, value]) => html`<dt>${key}</dt><dd>${value === "" ? "–" : value}</dd>`)}
    ${status.hardware === "" ? nothing : html`<dt>${msg("Hardware")}</dt><dd>${status.hardware}</dd>`}
    <dt>${msg("Heard")}</dt><dd>${formatAge(status.ageMs / 1000)}</dd>
  </dl>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-diagnostics": DiagnosticsTree;
  }
}
