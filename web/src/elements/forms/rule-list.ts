import { msg } from "@lit/localize";
import { css, html, LitElement, svg, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import type { PasswordRule } from "../../format/password-rules.js";
import { base, plainList } from "../base/base-style.js";

/** Rules, and which of them are kept so far: by shape and word, not by colour alone. */
@customElement("t-rules")
export class RuleChecklist extends LitElement {
  static override styles = [
    base,
    css`
      ul {
        display: grid;
        gap: var(--t-space-1);
        ${plainList}
        font-size: var(--t-size-s);
      }
      li {
        display: grid;
        grid-template-columns: auto 1fr;
        gap: var(--t-space-2);
        color: var(--t-muted);
      }
      .kept {
        color: var(--t-ok);
      }
      svg {
        inline-size: 1rem;
        block-size: 1rem;
        margin-block-start: 0.15em;
      }
    `,
  ];

  @property({ attribute: false }) rules: readonly PasswordRule[] = [];

  override render(): TemplateResult {
    return html`<ul aria-label=${msg("What a password needs")}>
      ${map(
        this.rules,
        (rule) => html`<li class=${rule.kept ? "kept" : ""}>
          <svg viewBox="0 0 16 16" aria-hidden="true">
            ${rule.kept
              ? svg`<path d="m3 8.5 3.2 3.2L13 4.8" fill="none" stroke="currentColor" stroke-width="2.2"></path>`
              : svg`<circle cx="8" cy="8" r="5" fill="none" stroke="currentColor" stroke-width="1.4"></circle>`}
          </svg>
          <span
            >${rule.words}${rule.must ? "" : msg(" (advice)")}<span class="visually-hidden"
              >${rule.kept ? msg(": kept") : msg(": not yet")}</span
            ></span
          >
        </li>`,
      )}
    </ul>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-rules": RuleChecklist;
  }
}
