/** Part of the form: what the camera shows about the target, moved by hand, turned, or as the panels of a mosaic. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { LoadController } from "../../../controllers/load.js";
import { base } from "../../../elements/base/base-style.js";
import { settled } from "../../../elements/base/stable-field.js";
import { renderAdvice } from "../../../elements/feedback/load-state.js";
import { forms } from "../../../elements/forms/form-style.js";
import type { FrameMove, SkyFrame } from "../../../elements/observatory/framing-view.js";
import { formatDuration } from "../../../format/duration.js";
import { adviceFor } from "../../../format/error-advice.js";
import type { FieldShape, SkyFieldShape } from "../../../generated/api.js";
import type { Mosaic } from "../../../sky/mosaic.js";
import { separation, type SkyPoint } from "../../../sky/tangent-plane.js";
import { apiContext } from "../../../state/contexts.js";
import type { HubApi } from "../../../wire/hub-api.js";
import { angleText, framingSpan, NEW_FRAMING, placeText, readFraming, sizeText, starRadius, type FramingDraft, type FramingField, type ReadFraming } from "./framing-draft.js";
import "../../../elements/forms/button.js";
import "../../../elements/forms/field.js";
import "../../../elements/observatory/framing-view.js";

/** Beyond this part of the drawing the frame is brought back into its middle. */
const OFF_MIDDLE = 0.3;
/** Panels that are turned less (°) look straight. */
const STRAIGHT = 0.5;

/**
 * @fires t-frame-moved detail is a `FrameMove`
 * @fires t-frame-turned detail is the position angle, as it was typed
 * @fires t-panels detail is the `Mosaic`, of which each panel becomes a request
 * @fires t-panels-undone the requests shall be one again
 */
@customElement("t-framing-panel")
export class FramingPanel extends LitElement {
  static override styles = [
    base,
    forms,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
        padding-block: var(--t-space-2);
      }
      .beside {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(16rem, 100%), 1fr));
        gap: var(--t-space-3) var(--t-space-4);
        align-items: start;
      }
      .numbers {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(8rem, 45%), 1fr));
        gap: var(--t-space-3);
        align-items: start;
      }
      .numbers > p,
      .numbers > .actions {
        grid-column: 1 / -1;
      }
    `,
  ];

  @property() site = "";
  /** Null while the target's coordinates cannot be read. */
  @property({ attribute: false }) centre: SkyPoint | null = null;
  @property() name = "";
  /** As it is typed, and what is wrong with it. */
  @property() angle = "";
  @property({ attribute: false }) angleProblem = "";
  /** The same, read; null: as the camera stands. */
  @property({ attribute: false }) angleDeg: number | null = null;
  /** How much the camera shows; null: the description does not say it. */
  @property({ attribute: false }) described: FieldShape | null = null;
  @property({ attribute: false }) others: readonly SkyFrame[] = [];
  /** Open shutter of one panel (s). */
  @property({ attribute: false }) shutterS = 0;
  /** More panels than that the hub does not take. */
  @property({ type: Number }) room = 1000;
  /** Panels were made, and may be one request again. */
  @property({ type: Boolean }) made = false;
  @state() private draft: FramingDraft = NEW_FRAMING;
  @state() private zoom = 1;
  /** Where a hand holds the frame; null while none does. */
  @state() private heldAt: SkyPoint | null = null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sky = new LoadController<SkyFieldShape>(this);
  private anchor: SkyPoint | null = null;
  private framing: ReadFraming | null = null;

  override willUpdate(): void {
    const centre = this.heldAt ?? this.centre;
    if (centre === null) return;
    this.framing = readFraming(this.draft, centre, this.described, this.angleDeg);
    const span = this.span;
    // Never under a hand that moves it.
    if (this.anchor === null || (this.heldAt === null && separation(this.anchor, centre) > span * OFF_MIDDLE)) this.anchor = centre;
    const { anchor } = this;
    const radius = starRadius(span);
    this.sky.load(`${this.site} ${placeText(anchor)} ${String(radius)}`, () => this.api.skyField(this.site, anchor, radius));
  }

  private get span(): number {
    const { framing } = this;
    return framingSpan(framing?.mosaic?.size ?? framing?.field ?? { width: 0.5, height: 0.5 }, this.zoom);
  }

  override render(): TemplateResult | typeof nothing {
    const { anchor, framing } = this;
    const centre = this.heldAt ?? this.centre;
    if (centre === null || anchor === null || framing === null) return html`<p class="muted">${msg("The sky is drawn once the target has coordinates.")}</p>`;
    const result = this.sky.result;
    return html`<div class="beside">
      <div>
        <t-framing-view
          .anchor=${anchor}
          .span=${this.span}
          .sky=${this.sky.value ?? null}
          .field=${framing.field ?? { width: 0, height: 0 }}
          .centre=${centre}
          .panels=${framing.mosaic?.panels ?? []}
          .others=${framing.field === null ? [] : this.others}
          .name=${this.name}
          @t-frame-moved=${this.onMoved}
        ></t-framing-view>
        <p class="small muted">${this.sky.value?.available === false ? msg("Stars of Hipparcos; the hub has no catalogue of nebulae and galaxies. Drag the frame, or move it by the arrow keys.") : msg("Stars of Hipparcos and objects of OpenNGC. Drag the frame, or move it by the arrow keys.")}</p>
        ${result.state === "failed" ? renderAdvice(adviceFor(result.error, msg("load the stars"))) : nothing}
      </div>
      <div class="numbers">${this.renderField(framing)} ${this.renderAngle()} ${this.renderPanels(framing, centre)}</div>
    </div>`;
  }

  private renderField({ field, problems }: ReadFraming): TemplateResult {
    if (this.described !== null) return html`<p>${msg(str`The camera shows ${sizeText(this.described)}.`)}</p>`;
    return html`<p>${field === null ? msg(html`The site's description does not say how much its camera shows (<code>night.field</code>). Write it here to see it:`) : msg(html`The site's description does not say how much its camera shows (<code>night.field</code>). `)}</p>
      ${this.renderNumber("width", msg("Width (°)"), problems)} ${this.renderNumber("height", msg("Height (°)"), problems)}`;
  }

  private renderAngle(): TemplateResult | typeof nothing {
    const { described } = this;
    if (described === null) return nothing;
    const stands = angleText(described.position_angle);
    if (!described.rotates) return html`<p>${msg(str`Its position angle is ${stands}°, and fixed: no rotator is described.`)}</p>`;
    return html`<t-field label=${msg("Position angle (°)")} hint=${msg(str`Of the top, from north through east; empty: ${stands}`)} .error=${this.angleProblem}
      ><input name="angle" inputmode="decimal" autocomplete="off" maxlength="10" .value=${settled(this.angle)} @input=${this.onAngle}
    /></t-field>`;
  }

  private renderPanels({ mosaic, problems, field }: ReadFraming, centre: SkyPoint): TemplateResult {
    return html`${this.renderNumber("across", msg("Panels across"), problems)} ${this.renderNumber("down", msg("Panels down"), problems)}
      ${this.renderNumber("overlap", msg("Overlap (%)"), problems)}
      <p role="status">${this.words(mosaic, centre)}</p>
      <div class="actions">
        <t-button kind="quiet" ?disabled=${field === null} @click=${this.onCloser}>${msg("Closer")}</t-button>
        <t-button kind="quiet" ?disabled=${field === null} @click=${this.onFarther}>${msg("Farther")}</t-button>
        ${mosaic === null || mosaic.panels.length < 2
          ? nothing
          : html`<t-button ?disabled=${mosaic.panels.length > this.room} @click=${this.onPanels}>${msg(str`Make ${mosaic.panels.length} requests, one for each panel`)}</t-button>`}
        ${this.made ? html`<t-button kind="quiet" @click=${this.onUndo}>${msg("Back to before the panels")}</t-button>` : nothing}
      </div>`;
  }

  private renderNumber(name: FramingField, label: string, problems: ReadFraming["problems"]): TemplateResult {
    return html`<t-field .label=${label} .error=${problems.get(name) ?? ""}><input name=${name} inputmode="decimal" autocomplete="off" maxlength="10" .value=${settled(this.draft[name])} @input=${this.onNumber} /></t-field>`;
  }

  private words(mosaic: Mosaic | null, centre: SkyPoint): string {
    const middle = msg(str`In the middle ${placeText(centre)} (J2000).`);
    if (mosaic === null) return middle;
    const many = mosaic.panels.length;
    if (many === 1) return middle;
    const whole = msg(str`${String(many)} panels show ${sizeText(mosaic.size)}: open shutter ${formatDuration(this.shutterS * many)} in all. What they are charged stands below once they are made.`);
    return many > this.room ? msg(str`${middle} ${whole}${twistText(mosaic)} A group has room for ${String(this.room)}.`) : `${middle} ${whole}${twistText(mosaic)}`;
  }

  private readonly onMoved = (event: CustomEvent<FrameMove>): void => {
    const { centre, done } = event.detail;
    // All of the form is read anew for another target: once, when it is let go.
    this.heldAt = done ? null : centre;
    if (done) this.dispatchEvent(new CustomEvent("t-frame-moved", { detail: event.detail }));
  };

  private readonly onAngle = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.dispatchEvent(new CustomEvent("t-frame-turned", { detail: event.target.value }));
  };

  private readonly onNumber = (event: Event): void => {
    const { target } = event;
    if (target instanceof HTMLInputElement) this.draft = { ...this.draft, [target.name]: target.value };
  };

  private readonly onCloser = (): void => {
    this.zoom = Math.max(1 / 8, this.zoom / 1.5);
  };

  private readonly onFarther = (): void => {
    this.zoom = Math.min(8, this.zoom * 1.5);
  };

  private readonly onPanels = (): void => {
    const detail = this.framing?.mosaic;
    if (detail === null || detail === undefined) return;
    this.draft = { ...this.draft, across: "1", down: "1" };
    this.dispatchEvent(new CustomEvent("t-panels", { detail }));
  };

  private readonly onUndo = (): void => {
    this.dispatchEvent(new CustomEvent("t-panels-undone"));
  };
}

/** Near a pole a camera that does not turn needs its panels closer. */
function twistText({ twist, scale }: Mosaic): string {
  if (twist < STRAIGHT || scale > 0.995) return "";
  return msg(str` The camera does not turn with the meridians, which run together here: its panels are turned against each other by up to ${twist.toFixed(0)}°, and stand ${((1 - scale) * 100).toFixed(0)} % closer, so that nothing is left out.`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-framing-panel": FramingPanel;
  }
  interface GlobalEventHandlersEventMap {
    "t-frame-turned": CustomEvent<string>;
    "t-panels": CustomEvent<Mosaic>;
    "t-panels-undone": CustomEvent;
  }
}
