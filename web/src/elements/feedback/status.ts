import { msg } from "@lit/localize";
import { css, html, LitElement, svg, type SVGTemplateResult, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { base } from "../base/base-style.js";

export type StatusKind = "online" | "offline" | "stale" | "unknown" | "ok" | "warn" | "bad" | "busy";

const WORDS: Readonly<Record<StatusKind, string>> = {
  online: msg("online"),
  offline: msg("offline"),
  stale: msg("stale"),
  unknown: msg("unknown"),
  ok: msg("in order"),
  warn: msg("look here"),
  bad: msg("in trouble"),
  busy: msg("working"),
};

/** Each kind has a shape of its own, so that it reads without colour. */
const SHAPES: Readonly<Record<StatusKind, SVGTemplateResult>> = {
  online: svg`<circle cx="6" cy="6" r="5" fill="currentColor"></circle>`,
  ok: svg`<circle cx="6" cy="6" r="5" fill="currentColor"></circle>`,
  offline: svg`<circle cx="6" cy="6" r="4.2" fill="none" stroke="currentColor" stroke-width="1.8"></circle><path d="M3 9 9 3" stroke="currentColor" stroke-width="1.6"></path>`,
  stale: svg`<circle cx="6" cy="6" r="4.2" fill="none" stroke="currentColor" stroke-width="1.8"></circle><path d="M6 3.4V6l1.8 1.2" fill="none" stroke="currentColor" stroke-width="1.4"></path>`,
  unknown: svg`<circle cx="6" cy="6" r="4.2" fill="none" stroke="currentColor" stroke-width="1.8" stroke-dasharray="2 1.6"></circle>`,
  warn: svg`<path d="M6 .8 11.6 11H.4z" fill="currentColor"></path>`,
  bad: svg`<path d="M1 1h10v10H1z" fill="currentColor"></path>`,
  busy: svg`<path d="M6 1.4A4.6 4.6 0 1 1 1.4 6" fill="none" stroke="currentColor" stroke-width="1.9"></path>`,
};

/** How something stands: a shape and a word, never colour alone. */
@customElement("t-status")
export class Status extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: inline-flex;
        align-items: center;
        gap: 0.45em;
        color: var(--t-muted);
        font-weight: var(--t-weight-strong);
      }
      svg {
        flex: none;
        inline-size: 0.75em;
        block-size: 0.75em;
      }
      :host(:is([kind="online"], [kind="ok"])) {
        color: var(--t-ok);
      }
      :host(:is([kind="offline"], [kind="bad"])) {
        color: var(--t-bad);
      }
      :host([kind="warn"]) {
        color: var(--t-warn);
      }
      :host([kind="stale"]) {
        color: var(--t-stale);
      }
      :host([kind="busy"]) {
        color: var(--t-info);
      }
      :host([kind="busy"]) svg {
        animation: turn 1.2s linear infinite;
      }
      @keyframes turn {
        to {
          rotate: 1turn;
        }
      }
    `,
  ];

  @property({ reflect: true }) kind: StatusKind = "unknown";
  /** The word; each kind has one of its own. */
  @property() word = "";

  override render(): TemplateResult {
    return html`<svg viewBox="0 0 12 12" aria-hidden="true">${SHAPES[this.kind]}</svg
      ><span>${this.word || WORDS[this.kind]}</span>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-status": Status;
  }
}
