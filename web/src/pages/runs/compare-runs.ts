/** The button that opens the choice of two runs. */

import { msg } from "@lit/localize";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import type { TimeSpan } from "../../series/time-window.js";
import type { ChosenRuns } from "./run-picker.js";
import "../../elements/forms/button.js";
import "./run-picker.js";

/** @fires t-runs which two are compared */
@customElement("t-compare-runs")
export class CompareRuns extends LitElement {
  static override styles = base;

  @property() site = "";
  @property() zone = "UTC";
  /** What the first run is unless another is chosen. */
  @property({ attribute: false }) span: TimeSpan = { fromUs: 0, toUs: 1 };
  @state() private open = false;

  override render(): TemplateResult {
    return html`<t-button kind="quiet" @click=${this.openPicker}>${msg("Compare runs")}</t-button>
      <t-run-picker .site=${this.site} .zone=${this.zone} .span=${this.span} ?open=${this.open} @t-runs=${this.onRuns} @t-close=${this.closePicker}></t-run-picker>`;
  }

  private readonly openPicker = (): void => {
    this.open = true;
  };

  private readonly closePicker = (): void => {
    this.open = false;
  };

  private readonly onRuns = ({ detail }: CustomEvent<ChosenRuns>): void => {
    this.open = false;
    this.dispatchEvent(new CustomEvent<ChosenRuns>("t-runs", { detail }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-compare-runs": CompareRuns;
  }
}
