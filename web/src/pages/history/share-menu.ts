/** The link to what is shown, to copy. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { control } from "../../elements/forms/input-style.js";
import type { ChoiceOption } from "../../elements/forms/choice.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/layout/menu.js";

const KINDS: readonly ChoiceOption[] = [
  { id: "window", label: msg("This very window") },
  { id: "live", label: msg("Going on with the time") },
];
const SAID_MS = 3000;

@customElement("t-share-menu")
export class ShareMenu extends LitElement {
  static override styles = [
    base,
    control,
    css`
      p,
      input {
        font-size: var(--t-size-s);
        font-weight: var(--t-weight);
      }
      input {
        inline-size: 100%;
      }
      @media (max-width: 45rem) {
        /* The panel hangs on what holds the menus: beside its own button there is no room. */
        t-menu {
          position: static;
        }
      }
    `,
  ];

  /** The link to exactly this window. */
  @property() fixed = "";
  /** The link to a window that goes with the time; empty where it stands still. */
  @property() live = "";

  @state() private kind = "window";
  @state() private said = "";

  @query("input") private readonly field!: HTMLInputElement;

  private timer: ReturnType<typeof setTimeout> | undefined;

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
  }

  override render(): TemplateResult {
    return html`<t-menu>
      <span slot="label">${msg("Share")}</span>
      <p>${msg("Opens the same signals, window and comparison for whoever may see them.")}</p>
      ${this.live === ""
          ? nothing
          : html`<t-choice label=${msg("What the link opens")} .options=${KINDS} chosen=${this.kind} @t-choose=${this.onChoose}></t-choice>`}
      <input type="text" readonly aria-label=${msg("Link")} .value=${this.link()} />
      <t-button kind="primary" @click=${this.copy}>${msg("Copy link")}</t-button>
      <p role="status">${this.said}</p>
    </t-menu>`;
  }

  private link(): string {
    return this.kind === "live" && this.live !== "" ? this.live : this.fixed;
  }

  private readonly onChoose = (event: CustomEvent<string>): void => {
    this.kind = event.detail;
  };

  private readonly copy = async (): Promise<void> => {
    try {
      await navigator.clipboard.writeText(this.link());
      this.said = msg("Copied.");
    } catch {
      // Without TLS or against the person's will the clipboard is closed.
      this.field.select();
      this.said = msg("This browser does not let it be copied: press Ctrl+C.");
    }
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.said = "";
    }, SAID_MS);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-share-menu": ShareMenu;
  }
}
