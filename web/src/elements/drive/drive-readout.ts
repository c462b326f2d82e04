/** What is asked of the vehicle, what it is told, and what it does. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { formatNumber } from "../../format/number.js";
import { shownUnit, toShown } from "../../format/unit.js";
import type { ShownUnitShape } from "../../generated/api.js";
import { base, quietText } from "../base/base-style.js";
import "../base/icon.js";

/** m/s and rad/s; NaN where it is not known. */
export interface Motion {
  readonly linear: number;
  readonly angular: number;
  /** m/s to the left; nothing where it does not move sideways. */
  readonly lateral?: number;
  /** rad to the left, of wheels that steer. */
  readonly steering?: number;
}

const DEGREES = 180 / Math.PI;
const NONE: Motion = { linear: Number.NaN, angular: Number.NaN };

@customElement("t-drive-readout")
export class DriveReadout extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        gap: var(--t-space-2);
      }
      table {
        inline-size: 100%;
        border-collapse: collapse;
        font-variant-numeric: tabular-nums;
      }
      th {
        padding: 0.15rem 0 0.15rem var(--t-space-2);
        vertical-align: bottom;
        ${quietText}
        font-weight: var(--t-weight);
        text-align: end;
      }
      tbody th {
        padding-inline-start: 0;
        text-align: start;
      }
      td {
        padding: 0.15rem 0;
        text-align: end;
      }
      tbody tr {
        border-block-start: 1px solid var(--t-line);
      }
      td.measured {
        font-weight: var(--t-weight-strong);
      }
      .cap {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property({ attribute: false }) asked: Motion = NONE;
  /** What the gateway tells the robot, after its own limits. */
  @property({ attribute: false }) told: Motion = NONE;
  @property({ attribute: false }) measured: Motion = NONE;
  /** How speeds and turns are shown; null: in m/s and rad/s. */
  @property({ attribute: false }) shownSpeed: ShownUnitShape | null = null;
  @property({ attribute: false }) shownTurn: ShownUnitShape | null = null;
  @property({ type: Boolean }) sideways = false;
  @property({ type: Boolean }) steers = false;
  /** The characters since the last `s`, to a robot that is driven by them; empty for others. */
  @property() sent = "";
  /** Why the speed is capped; empty when it is not. */
  @property() cap = "";
  /** Why the gateway refuses frames; empty when it does not. */
  @property() refusal = "";

  override render(): TemplateResult {
    return html`
      <table>
        <thead>
          <tr>
            <td></td>
            <th scope="col">${msg("You ask")}</th>
            <th scope="col">${msg("Sent to the robot")}</th>
            <th scope="col">${msg("Measured")}</th>
          </tr>
        </thead>
        <tbody>
          ${renderRow(msg("Speed"), "m/s", this.shownSpeed, [this.asked.linear, this.told.linear, this.measured.linear])}
          ${this.sideways ? renderRow(msg("To the left"), "m/s", this.shownSpeed, [this.asked.lateral, this.told.lateral, this.measured.lateral]) : nothing}
          ${this.steers ? renderRow(msg("Steering"), "°", null, [this.asked, this.told, this.measured].map(({ steering }) => (steering ?? Number.NaN) * DEGREES)) : nothing}
          ${this.steers ? nothing : renderRow(msg("Turn"), "rad/s", this.shownTurn, [this.asked.angular, this.told.angular, this.measured.angular])}
          ${this.sent === ""
            ? nothing
            : html`<tr>
                <th scope="row">${msg("Characters sent")}</th>
                <td></td>
                <td>${this.sent}</td>
                <td></td>
              </tr>`}
        </tbody>
      </table>
      ${this.cap === "" ? nothing : html`<p class="cap" role="status"><t-icon name="warn"></t-icon>${this.cap}</p>`}
      ${this.refusal === ""
        ? nothing
        : html`<p class="cap" role="status"><t-icon name="warn"></t-icon>${msg("Gateway:")} ${this.refusal}</p>`}
    `;
  }
}

function renderRow(name: string, stored: string, shown: ShownUnitShape | null, values: readonly (number | undefined)[]): TemplateResult {
  const { unit, decimals } = shownUnit({ unit: stored, decimals: stored === "°" ? 0 : 2, shown });
  const [asked, told, measured] = values.map((value) => formatNumber(toShown(shown, value ?? Number.NaN), decimals));
  return html`<tr>
    <th scope="row">${name}, ${unit}</th>
    <td>${asked}</td>
    <td>${told}</td>
    <td class="measured">${measured}</td>
  </tr>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-drive-readout": DriveReadout;
  }
}
