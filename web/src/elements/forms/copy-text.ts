import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { base, quietText } from "../base/base-style.js";
import "./button.js";
import "../base/icon.js";

const SAID_FOR_MS = 4000;

/** A text to take elsewhere, exactly: a command, a code, a secret. */
@customElement("t-copy")
export class CopyText extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-1);
        min-inline-size: 0;
      }
      .label {
        font-weight: var(--t-weight-strong);
        font-size: var(--t-size-s);
      }
      .row {
        display: flex;
        flex-wrap: wrap;
        align-items: stretch;
        gap: var(--t-space-2);
      }
      code {
        flex: 1 1 14rem;
        min-inline-size: 0;
        padding: var(--t-space-2) var(--t-space-3);
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
        background: var(--t-raised);
        font: var(--t-size-s) / 1.6 var(--t-mono);
        overflow-wrap: anywhere;
        white-space: pre-wrap;
        user-select: all;
        align-content: center;
      }
      .said {
        ${quietText}
      }
    `,
  ];

  @property() text = "";
  @property() label = "";

  @state() private said = "";
  @query("code") private readonly code!: HTMLElement;
  private timer: ReturnType<typeof setTimeout> | undefined;

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
  }

  override render(): TemplateResult {
    return html`
      ${this.label === "" ? nothing : html`<span class="label">${this.label}</span>`}
      <div class="row">
        <code>${this.text}</code>
        <t-button label=${msg(str`Copy ${this.label.toLowerCase()}`)} @click=${this.copy}
          ><t-icon name="copy"></t-icon>${msg("Copy")}</t-button
        >
      </div>
      <span class="said" role="status">${this.said}</span>
    `;
  }

  private readonly copy = (): void => {
    void this.writeClipboard();
  };

  private async writeClipboard(): Promise<void> {
    try {
      await navigator.clipboard.writeText(this.text);
      this.announceCopy(msg("Copied."));
    } catch {
      // A page over plain http may not write there; the person still can.
      const range = document.createRange();
      range.selectNodeContents(this.code);
      const selection = getSelection();
      selection?.removeAllRanges();
      selection?.addRange(range);
      this.announceCopy(msg("It is marked now: copy it by hand."));
    }
  }

  private announceCopy(words: string): void {
    this.said = words;
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      this.said = "";
    }, SAID_FOR_MS);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-copy": CopyText;
  }
}
