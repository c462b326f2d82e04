/** What is asked of the vehicle, what it is told, and what it does. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { formatMs } from "../../format/duration.js";
import { formatNumber } from "../../format/number.js";
import { base } from "../base.js";
import "../icon.js";

/** m/s and rad/s; NaN where it is not known. */
export interface Motion {
  readonly linear: number;
  readonly angular: number;
}

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
        padding: 0.15rem 0;
        color: var(--t-muted);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight);
        text-align: end;
      }
      th:first-child {
        text-align: start;
      }
      td {
        padding: 0.15rem 0;
        text-align: end;
      }
      tbody tr {
        border-block-start: 1px solid var(--t-line);
      }
      tr.measured td {
        font-weight: var(--t-weight-strong);
      }
      .cap {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
      .foot {
        display: flex;
        flex-wrap: wrap;
        gap: 0 var(--t-space-4);
        color: var(--t-muted);
        font-size: var(--t-size-s);
        font-variant-numeric: tabular-nums;
      }
    `,
  ];

  @property({ attribute: false }) asked: Motion = NONE;
  /** What the gateway tells the robot, after its own limits. */
  @property({ attribute: false }) told: Motion = NONE;
  @property({ attribute: false }) measured: Motion = NONE;
  /** Why the speed is capped; empty when it is not. */
  @property() cap = "";
  /** Why the gateway refuses frames; empty when it does not. */
  @property() refusal = "";
  /** Page to gateway and back (ms); NaN when it is not measured. */
  @property({ type: Number }) loop = Number.NaN;

  override render(): TemplateResult {
    return html`
      <table>
        <thead>
          <tr>
            <th scope="col"><span class="visually-hidden">What</span></th>
            <th scope="col">speed, m/s</th>
            <th scope="col">turn, rad/s</th>
          </tr>
        </thead>
        <tbody>
          ${row("You ask", this.asked)} ${row("Robot is told", this.told)}
          ${row("Measured", this.measured, "measured")}
        </tbody>
      </table>
      ${this.cap === "" ? nothing : html`<p class="cap" role="status"><t-icon name="warn"></t-icon>${this.cap}</p>`}
      ${this.refusal === ""
        ? nothing
        : html`<p class="cap" role="status"><t-icon name="warn"></t-icon>Gateway: ${this.refusal}</p>`}
      <p class="foot"><span>Link there and back: ${formatMs(this.loop)}</span></p>
    `;
  }
}

function row(name: string, motion: Motion, kind = ""): TemplateResult {
  return html`<tr class=${kind}>
    <th scope="row">${name}</th>
    <td>${formatNumber(motion.linear, 2)}</td>
    <td>${formatNumber(motion.angular, 2)}</td>
  </tr>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-drive-readout": DriveReadout;
  }
}
