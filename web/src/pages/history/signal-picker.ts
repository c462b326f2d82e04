/** Which channels are shown: check boxes by device. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { control } from "../../elements/forms/input-style.js";
import type { ChannelRow } from "./data/channel-rows.js";
import "../../elements/forms/button.js";

/** @fires t-pick detail is the addresses that are chosen now, in the order of the description */
@customElement("t-signal-picker")
export class SignalPicker extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-3);
        align-content: start;
      }
      .head {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
      }
      input[type="search"] {
        flex: 1;
      }
      fieldset {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        margin: 0;
        padding: 0;
        border: 0;
        min-inline-size: 0;
      }
      legend {
        padding: 0;
        ${quietText}
        font-weight: var(--t-weight-strong);
      }
      label {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: 2.25rem;
        border-radius: var(--t-radius-s);
        cursor: pointer;
      }
      label:hover {
        background: var(--t-raised);
      }
      .name {
        flex: 1;
        min-inline-size: 0;
        overflow: hidden;
        text-overflow: ellipsis;
        white-space: nowrap;
      }
      .former {
        padding-block-start: var(--t-space-3);
        border-block-start: 1px solid var(--t-line);
      }
      p {
        font-size: var(--t-size-s);
      }
      .unit {
        ${quietText}
      }
      input[type="checkbox"] {
        inline-size: 1.15rem;
        block-size: 1.15rem;
        margin: 0 0 0 var(--t-space-1);
        accent-color: var(--t-accent);
      }
      @media (pointer: coarse) {
        label {
          min-block-size: var(--t-touch);
        }
      }
    `,
  ];

  @property({ attribute: false }) rows: readonly ChannelRow[] = [];
  @property({ attribute: false }) chosen: readonly string[] = [];
  /** What is no longer described could not be listed. */
  @property({ type: Boolean }) incomplete = false;

  @state() private filter = "";

  override render(): TemplateResult {
    const words = this.filter.toLowerCase().split(/\s+/).filter(Boolean);
    const fits = this.rows.filter(({ name, device, address }) => {
      const text = `${device.name} ${name} ${address}`.toLowerCase();
      return words.every((word) => text.includes(word));
    });
    const described = fits.filter(({ former }) => !former);
    const former = fits.filter((row) => row.former);
    const devices = [...new Set(described.map(({ device }) => device))];
    return html`
      <div class="head">
        <input type="search" placeholder=${msg("Filter", { id: "filter.verb" })} aria-label=${msg("Filter signals")} @input=${this.onInput} />
        <t-button kind="quiet" ?disabled=${this.chosen.length === 0} @click=${this.clearChoice}>${msg("Clear")}</t-button>
      </div>
      ${repeat(
        devices,
        (device) => device.id,
        (device) => html`<fieldset @change=${this.onToggle}>
          <legend>${device.name}</legend>
          ${this.renderBoxes(described.filter((row) => row.device === device))}
        </fieldset>`,
      )}
      ${former.length === 0
        ? nothing
        : html`<fieldset class="former" @change=${this.onToggle}>
            <legend>${msg("No longer in the description")}</legend>
            ${this.renderBoxes(former)}
          </fieldset>`}
      ${this.incomplete ? html`<p class="muted">${msg("Signals that are no longer in the description cannot be listed now.")}</p>` : nothing}
      ${fits.length === 0 && this.rows.length > 0 ? html`<p class="muted">${msg("No signal is called like this.")}</p>` : nothing}
    `;
  }

  private renderBoxes(rows: readonly ChannelRow[]): unknown {
    return repeat(
      rows,
      (row) => row.address,
      (row) => html`<label title=${row.address}
        ><input type="checkbox" .value=${row.address} .checked=${this.chosen.includes(row.address)} /><span class="name"
          >${row.name}${row.former ? html` <span class="unit">${row.device.name}</span>` : nothing}</span
        ><span class="unit">${row.type === "number" ? row.unit : row.type === "state" ? msg("state", { id: "state.type" }) : msg("text", { id: "text.type" })}</span></label
      >`,
    );
  }

  private readonly onInput = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.filter = event.target.value;
  };

  private readonly onToggle = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    const { value, checked } = event.target;
    const next = new Set(this.chosen);
    if (checked) next.add(value);
    else next.delete(value);
    this.fireChoice(this.rows.map(({ address }) => address).filter((address) => next.has(address)));
  };

  private readonly clearChoice = (): void => {
    this.fireChoice([]);
  };

  private fireChoice(detail: readonly string[]): void {
    this.dispatchEvent(new CustomEvent("t-pick", { detail }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-signal-picker": SignalPicker;
  }
  interface HTMLElementEventMap {
    "t-pick": CustomEvent<readonly string[]>;
  }
}
