/** Where the telescope shall look: by name or by coordinates, how it stands tonight, and the way there. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import type { CommandClient } from "../../controllers/drive/command-client.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { checkArgument, initialText, type ArgumentValue } from "../../elements/command/argument-check.js";
import { formatNumber } from "../../format/number.js";
import { adviceFor } from "../../format/error-advice.js";
import { formatAzimuth, formatDec, formatRa } from "../../format/sexagesimal.js";
import { formatClock } from "../../format/time.js";
import { formText } from "../../format/form-values.js";
import { moonFrom, sunFrom } from "../../sky/sun-and-moon.js";
import { nightTrack, visibilityOf, visibilityText, type NightTrack, type Visibility } from "../../sky/night-visibility.js";
import type { GeoPlace } from "../../sky/coordinates.js";
import { apiContext } from "../../state/contexts.js";
import type { DeviceShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { partStyle } from "./device-part.js";
import type { CommandButton, Slew } from "./roles.js";
import { aimOf, catalogueTarget, ownTargets, refusalOf, typedTarget, type CoordinateProblem, type SkyTarget } from "./sky-target.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/forms/field.js";
import "../../elements/base/icon.js";
import "../../elements/observatory/night-curve.js";
import "../command/command-buttons.js";

const WAYS = [
  { id: "name", label: msg("By name") },
  { id: "place", label: msg("By coordinates") },
] as const;
const EQUINOXES = [
  { id: "j2000", label: "J2000" },
  { id: "date", label: msg("of date") },
] as const;
const EVERY_MS = 60_000;

/** @fires t-target detail is the target that was chosen, or null */
@customElement("t-goto")
export class GotoForm extends LitElement {
  static override styles = [
    base,
    partStyle,
    css`
      form {
        display: grid;
        gap: var(--t-space-3);
      }
      .pair {
        display: grid;
        grid-template-columns: minmax(0, 1fr) minmax(0, 1fr) auto;
        align-items: start;
        gap: var(--t-space-3);
      }
      /* Beside the field itself, whatever stands above and below that. */
      form t-button {
        margin-block-start: calc(var(--t-size-s) * 1.45 + var(--t-space-1));
      }
      .one {
        display: grid;
        grid-template-columns: minmax(0, 1fr) auto;
        align-items: start;
        gap: var(--t-space-3);
      }
      fieldset {
        display: grid;
        gap: var(--t-space-1);
        margin: 0;
        padding: 0;
        border: 0;
        min-inline-size: 0;
      }
      legend {
        padding: 0;
        ${quietText}
      }
      label {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        gap: 0 var(--t-space-3);
        align-items: center;
        min-block-size: var(--t-touch);
        cursor: pointer;
      }
      input[type="radio"] {
        inline-size: 1.2rem;
        block-size: 1.2rem;
        margin: 0;
      }
      dl {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        gap: var(--t-space-1) var(--t-space-4);
        margin: 0;
      }
      dt {
        color: var(--t-muted);
      }
      dd {
        margin: 0;
        font-variant-numeric: tabular-nums;
      }
      .warn {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        gap: var(--t-space-2);
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
      @media (max-width: 45rem) {
        .pair t-button {
          grid-column: 1 / -1;
          margin-block-start: 0;
        }
        .pair {
          grid-template-columns: minmax(0, 1fr) minmax(0, 1fr);
        }
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) device: DeviceShape | null = null;
  @property({ attribute: false }) line: CommandClient | null = null;
  @property({ type: Boolean }) online = true;
  @property({ attribute: false }) place: GeoPlace | null = null;
  @property({ attribute: false }) slew: Slew | null = null;
  @property() zone = "UTC";
  /** The moment (ms since 1970). */
  @property({ type: Number }) ms = 0;

  @state() private way: "name" | "place" = "name";
  @state() private dated = false;
  @state() private found: readonly SkyTarget[] | null = null;
  @state() private target: SkyTarget | null = null;
  @state() private problem: CoordinateProblem | { readonly field: "name"; readonly text: string } | null = null;
  @state() private busy = false;
  @state() private failure: unknown = null;
  @query("form") private readonly form!: HTMLFormElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private night: { night: NightTrack; seen: Visibility; moon: readonly number[] } | null = null;
  private computed = 0;

  override willUpdate(): void {
    if (this.target === null || this.place === null) this.night = null;
    else if (this.night === null || this.ms - this.computed >= EVERY_MS) this.computeVisibility(this.target, this.place);
  }

  private computeVisibility(target: SkyTarget, place: GeoPlace): void {
    const night = nightTrack(target.at(this.ms), place, this.ms);
    const moon = night.points.map(({ ms }) => moonFrom(place, ms).alt);
    this.night = { night, seen: visibilityOf(night, this.pointingLimits.horizon), moon };
    this.computed = this.ms;
  }

  override render(): TemplateResult {
    return html`<div class="card" role="group" aria-labelledby="to">
      <h2 id="to">${msg("Go to")}</h2>
      <form novalidate @submit=${this.onSubmit}>
        <t-choice label=${msg("How to say where to")} .options=${WAYS} .chosen=${this.way} @t-choose=${this.onMethodChange}></t-choice>
        ${this.way === "name" ? this.renderNameForm() : this.renderCoordinatesForm()}
      </form>
      ${this.failure === null ? nothing : renderAdvice(adviceFor(this.failure, msg("the catalogue of names")))} ${this.renderChoices()}
      ${this.target === null ? nothing : this.renderTarget(this.target)}
    </div>`;
  }

  private problemOf(field: "name" | "ra" | "dec"): string {
    return this.problem?.field === field ? this.problem.text : "";
  }

  private renderNameForm(): TemplateResult {
    return html`<div class="one">
      <t-field label=${msg("Name")} hint=${msg("M 31, NGC 7000, Orion Nebula, Vega, α Lyr, Moon")} .error=${this.problemOf("name")}>
        <input name="name" autocomplete="off" autocapitalize="off" spellcheck="false" maxlength="60" />
      </t-field>
      <t-button type="submit" ?busy=${this.busy}>${msg("Find")}</t-button>
    </div>`;
  }

  private renderCoordinatesForm(): TemplateResult {
    return html`<div class="pair">
        <t-field label=${msg("Right ascension")} hint=${msg("05:34:32 or 5.5756 (h)")} .error=${this.problemOf("ra")}>
          <input name="ra" autocomplete="off" spellcheck="false" maxlength="40" />
        </t-field>
        <t-field label=${msg("Declination")} hint=${msg("\u221205:23:28 or \u22125.39 (°)")} .error=${this.problemOf("dec")}>
          <input name="dec" autocomplete="off" spellcheck="false" maxlength="40" />
        </t-field>
        <t-button type="submit">${msg("Look", { id: "look.verb" })}</t-button>
      </div>
      <t-choice label=${msg("Equinox")} .options=${EQUINOXES} .chosen=${this.dated ? "date" : "j2000"} @t-choose=${this.onEquinoxChange}></t-choice>`;
  }

  private renderChoices(): unknown {
    const { found } = this;
    if (found === null || found.length < 2) return nothing;
    return html`<fieldset>
      <legend>${msg("Which one?")}</legend>
      ${map(
        found,
        (target, i) => html`<label
          ><input type="radio" name="which" .value=${String(i)} .checked=${target === this.target} @change=${this.onPick} /><span><strong>${target.name}</strong> <span class="muted">${target.about}</span></span></label
        >`,
      )}
    </fieldset>`;
  }

  private renderTarget(target: SkyTarget): TemplateResult {
    const { place, night } = this;
    const dated = target.at(this.ms);
    const aim = place === null ? null : aimOf(target, place, this.ms);
    const refusal = aim === null || place === null ? "" : refusalOf(aim, place, this.ms, this.pointingLimits);
    const words =
      aim === null || place === null || night === null
        ? ""
        : visibilityText(aim, sunFrom(place, this.ms).alt, night.seen, this.pointingLimits.horizon, (ms) => formatClock(ms * 1000, this.zone).slice(0, 5));
    return html`<div>
        <h3>${target.name}</h3>
        <p class="muted">${target.about}</p>
      </div>
      <dl>
        ${target.j2000 === null ? nothing : html`<dt>J2000</dt><dd>${formatRa(target.j2000.ra)} ${formatDec(target.j2000.dec)}</dd>`}
        <dt>${msg("Of date")}</dt>
        <dd>${formatRa(dated.ra)} ${formatDec(dated.dec)}</dd>
        ${aim === null ? nothing : html`<dt>${msg("Now")}</dt><dd>${msg(str`${formatNumber(aim.alt, 1)}° high, azimuth ${formatAzimuth(aim.az)}`)}</dd>`}
      </dl>
      ${night === null
        ? html`<p class="note">${msg("Visibility tonight needs the site's position, which you may not see.")}</p>`
        : html`<p>${words}</p>
            <t-night-curve
              .night=${night.night}
              .seen=${night.seen}
              .moon=${night.moon}
              .limit=${this.pointingLimits.horizon}
              .ms=${this.ms}
              .zone=${this.zone}
              .words=${words}
            ></t-night-curve>`}
      ${refusal === "" ? nothing : html`<p class="warn"><t-icon name="warn"></t-icon><span>${refusal}</span></p>`} ${this.renderSendButton(target, dated)}`;
  }

  private renderSendButton(target: SkyTarget, { ra, dec }: { ra: number; dec: number }): unknown {
    const { slew } = this;
    if (slew === null) return html`<p class="note">${msg("You may look, but not send the telescope there.")}</p>`;
    const others = slew.command.arguments.filter(({ id }) => id !== slew.ra && id !== slew.dec);
    const inDegrees = slew.command.arguments.find(({ id }) => id === slew.ra)?.unit === "°";
    const args: Record<string, ArgumentValue> = { [slew.ra]: inDegrees ? ra * 15 : ra, [slew.dec]: dec };
    for (const other of others) {
      const start = checkArgument(other, initialText(other));
      if (start.ok) args[other.id] = start.value;
    }
    const deeds: readonly CommandButton[] = [{ command: slew.command, args, label: `${slew.command.name} ${target.name}`, kind: "primary" }];
    return html`<t-deeds .site=${this.site} .device=${this.device} .line=${this.line} .deeds=${deeds} .online=${this.online}></t-deeds>`;
  }

  private get pointingLimits(): { horizon: number; sun: number } {
    return { horizon: this.device?.pointing?.horizon ?? 0, sun: this.device?.pointing?.sun ?? 0 };
  }

  private chooseTarget(target: SkyTarget | null): void {
    this.target = target;
    this.night = null;
    this.dispatchEvent(new CustomEvent("t-target", { detail: target }));
  }

  private readonly onPick = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.chooseTarget(this.found?.[Number(event.target.value)] ?? null);
  };

  private readonly onMethodChange = (event: CustomEvent<string>): void => {
    this.way = event.detail === "place" ? "place" : "name";
    this.problem = null;
    this.found = null;
  };

  private readonly onEquinoxChange = (event: CustomEvent<string>): void => {
    this.dated = event.detail === "date";
    if (this.target !== null) this.findTarget();
  };

  private readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    this.problem = null;
    this.failure = null;
    if (this.way === "place") this.findTarget();
    else void this.searchCatalogue(this.typedValue("name"));
  };

  private typedValue(name: string): string {
    return formText(new FormData(this.form), name);
  }

  private findTarget(): void {
    const made = typedTarget(this.typedValue("ra"), this.typedValue("dec"), this.dated);
    this.found = null;
    this.problem = "field" in made ? made : null;
    this.chooseTarget("field" in made ? null : made);
  }

  private async searchCatalogue(name: string): Promise<void> {
    if (name === "") {
      this.problem = { field: "name", text: msg("Write a name.") };
      return;
    }
    this.busy = true;
    const own = ownTargets(name);
    try {
      const { available, objects } = await this.api.searchSky(this.site, name);
      this.found = [...own, ...objects.map(catalogueTarget)];
      if (this.found.length === 0) {
        const text = available
          ? msg(str`Nothing goes by the name ${name}. Planets and comets are not in the catalogue: give their coordinates.`)
          : msg("This hub knows the bright stars and the Moon only: install talaia[observatory] on it for NGC, IC and Messier.");
        this.problem = { field: "name", text };
      }
    } catch (error) {
      this.found = own;
      if (own.length === 0) this.failure = error;
    }
    this.busy = false;
    this.chooseTarget(this.found[0] ?? null);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-goto": GotoForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-target": CustomEvent<SkyTarget | null>;
  }
}
