/** Zones and lines of a camera below its picture: what they are called, what counts at them, and what can be done. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base/base-style.js";
import { settled } from "../../elements/base/stable-field.js";
import type { PictureMark } from "../../elements/camera/mark-shapes.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { LEAST_POINTS, reversedShape, type DrawnShape } from "./zone-shapes.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";

/** Another shape in the place of one, or none; typing goes on `along`. */
export interface ShapeChange {
  readonly index: number;
  readonly shape: DrawnShape | null;
  readonly along: boolean;
}

/**
 * @fires t-shape-change something of a shape was changed: detail is a `ShapeChange`
 * @fires t-shape-choose detail is the index of the shape that was meant
 */
@customElement("t-shape-list")
export class ShapeList extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      ul.rows > li {
        grid-template-columns: minmax(10rem, 1fr) minmax(10rem, 1fr) auto;
        padding-inline-start: var(--t-space-3);
        border-inline-start: 3px solid transparent;
      }
      ul.rows > li.chosen {
        border-inline-start-color: var(--t-accent);
      }
      .counts {
        font-variant-numeric: tabular-nums;
      }
      @media (max-width: 45rem) {
        ul.rows > li {
          grid-template-columns: minmax(0, 1fr);
        }
      }
    `,
  ];

  @property({ attribute: false }) shapes: readonly DrawnShape[] = [];
  @property({ type: Number }) chosen = -1;
  /** What counts now at those that the gateway knows. */
  @property({ attribute: false }) marks: readonly PictureMark[] = [];
  /** What can be counted. */
  @property({ attribute: false }) classes: readonly string[] = [];

  override render(): TemplateResult {
    return html`<ul class="rows" aria-label=${msg("Zones and lines")}>
      ${map(this.shapes, (shape, index) => this.renderRow(shape, index))}
    </ul>`;
  }

  private renderRow(shape: DrawnShape, index: number): TemplateResult {
    const mark = this.marks.find(({ kind, id }) => kind === shape.kind && id === shape.id);
    const change = (changed: DrawnShape | null, along = false): void => {
      const detail: ShapeChange = { index, shape: changed, along };
      this.dispatchEvent(new CustomEvent("t-shape-change", { detail }));
    };
    const rename = (event: Event): void => {
      change({ ...shape, name: (event.target as HTMLInputElement).value }, true);
    };
    const count = (event: Event): void => {
      change({ ...shape, counts: (event.target as HTMLSelectElement).value });
    };
    const choose = (): void => {
      this.dispatchEvent(new CustomEvent("t-shape-choose", { detail: index }));
    };
    const reverse = (): void => {
      change(reversedShape(shape));
    };
    const remove = (): void => {
      change(null);
    };
    return html`<li class=${index === this.chosen ? "chosen" : ""} data-shape=${index} @focusin=${choose}>
      <t-field label=${shape.kind === "zone" ? msg("Zone, name") : msg("Line, name")} .error=${shape.name.trim() === "" ? msg("It needs a name.") : ""}>
        <input type="text" maxlength="60" autocomplete="off" .value=${settled(shape.name)} @input=${rename} />
      </t-field>
      ${mark !== undefined && mark.counts.length > 0
        ? html`<div class="counts"><span class="muted">${msg("Now:")}</span> ${mark.counts.join(", ")}</div>`
        : html`<t-field label=${shape.kind === "zone" ? msg("Count who is in it") : msg("Count who crosses it")}>
            <select @change=${count}>
              ${renderOptions([["", msg("nothing yet")], ...this.classes.map((label): [string, string] => [label, label])], shape.counts)}
            </select>
          </t-field>`}
      <div class="actions">
        ${shape.kind === "line" ? html`<t-button label=${msg(str`Reverse the direction of ${shape.name}`)} @click=${reverse}>${msg("Reverse")}</t-button>` : nothing}
        <t-button label=${msg(str`Delete ${shape.name}`)} @click=${remove}>${msg("Delete")}</t-button>
      </div>
      ${shape.points.length < LEAST_POINTS[shape.kind] ? html`<p class="muted">${msg("It has too few points to be drawn.")}</p>` : nothing}
    </li>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-shape-list": ShapeList;
  }
  interface HTMLElementEventMap {
    "t-shape-change": CustomEvent<ShapeChange>;
    "t-shape-choose": CustomEvent<number>;
  }
}
