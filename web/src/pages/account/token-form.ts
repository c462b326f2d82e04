/** What a new token shall be: a name, a day of its end, and some of its maker's rights. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderFormActions, renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { knownZone } from "../../format/time.js";
import { DAY_US, ZoneClock } from "../../series/zone-clock.js";
import { apiContext } from "../../state/contexts.js";
import {
  EXTRA_RIGHT_NAMES,
  givesExtra,
  inheritedLevel,
  inheritsExtra,
  LEVELS,
  levelRank,
  ownLevel,
  withExtra,
  withLevel,
  type AccessLevel,
  type ExtraRight,
} from "../../state/rights.js";
import type { DeviceSummary, Me, PermissionShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { scopesOf, type TokenScope } from "./token-scopes.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/field.js";

export interface TokenWish {
  readonly name: string;
  readonly endsUs: number;
  readonly permissions: readonly PermissionShape[];
}

const FIRST_DAYS = 90;
/** The hub takes no later end. */
const MOST_DAYS = 364;

/**
 * @fires t-wish detail is what the person wants
 * @fires t-cancel
 */
@customElement("t-token-form")
export class TokenForm extends LitElement {
  static override styles = [
    base,
    sheets,
    control,
    css`
      form {
        display: grid;
        gap: var(--t-space-4);
        padding-block-end: var(--t-space-4);
      }
      fieldset {
        display: grid;
        gap: var(--t-space-1);
        max-inline-size: 32rem;
        margin: 0;
        padding: 0;
        border: 0;
      }
      legend {
        padding: 0;
        margin-block-end: var(--t-space-1);
        font-weight: var(--t-weight-strong);
        font-size: var(--t-size-s);
      }
      label {
        display: flex;
        align-items: center;
        justify-content: space-between;
        gap: var(--t-space-3);
        min-block-size: var(--t-touch);
        border-block-end: 1px solid var(--t-line);
      }
      label.d1 span {
        padding-inline-start: var(--t-space-4);
      }
      label.d2 span {
        padding-inline-start: var(--t-space-6);
      }
      select {
        min-inline-size: 7rem;
      }
      .error {
        color: var(--t-bad);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
      }
    `,
  ];

  @property({ attribute: false }) person: Me | null = null;
  @property() zone = "UTC";
  @property({ type: Boolean }) busy = false;
  @state() private permissions: readonly PermissionShape[] = [];
  @state() private errors = { name: "", ends: "", rights: "" };
  @query("#name") private readonly name!: HTMLInputElement;
  @query("#ends") private readonly ends!: HTMLInputElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly devices = new LoadController<readonly DeviceSummary[]>(this);

  override willUpdate(): void {
    this.devices.load("devices", () => this.api.devices());
  }

  override firstUpdated(): void {
    void focusInside(this, "input");
  }

  override render(): TemplateResult {
    const clock = this.clock();
    const now = Date.now() * 1000;
    const day = (days: number): string => clock.toInput(now + days * DAY_US).slice(0, 10);
    return html`<form novalidate @submit=${this.onSubmit}>
      <div class="fields">
        <t-field label=${msg("Name")} hint=${msg("What the script is for")} error=${this.errors.name}>
          <input id="name" autocomplete="off" maxlength="100" />
        </t-field>
        <t-field label=${msg("Last day")} hint=${msg(str`It ends with that day in ${clock.zone}`)} error=${this.errors.ends}>
          <input id="ends" type="date" min=${day(0)} max=${day(MOST_DAYS)} .defaultValue=${day(FIRST_DAYS)} />
        </t-field>
      </div>
      ${renderLoaded(this.devices, msg("the list of your devices"), (devices) => this.renderRights(devices))}
      ${renderFormActions({ submit: msg("Make the token"), busy: this.busy, cancel: this.onCancel })}
    </form>`;
  }

  private renderRights(devices: readonly DeviceSummary[]): TemplateResult {
    const scopes = scopesOf(this.person?.permissions ?? [], devices);
    if (scopes.length === 0) {
      return html`<p class="muted">${msg("You have no rights to give; the token can read public data only.")}</p>`;
    }
    return html`<fieldset>
      <legend>${msg("What it may do")}</legend>
      ${repeat(
        scopes,
        (scope) => `${scope.site}\n${scope.device}`,
        (scope) => this.renderScope(scope),
      )}
      <span role="alert">${this.errors.rights === "" ? nothing : html`<span class="error">${this.errors.rights}</span>`}</span>
    </fieldset>`;
  }

  private renderScope(scope: TokenScope): TemplateResult {
    const from = inheritedLevel(this.permissions, scope);
    const own = ownLevel(this.permissions, scope);
    const shown = levelRank(own) > levelRank(from) ? own : from;
    const choices = LEVELS.filter((level) => levelRank(level) >= levelRank(from) && levelRank(level) <= levelRank(scope.most));
    const onLevelChange = (event: Event): void => {
      if (!(event.target instanceof HTMLSelectElement)) return;
      const level = LEVELS.find((level) => level === (event.target as HTMLSelectElement).value) ?? "none";
      this.setLevel(scope, level === from ? "none" : level);
    };
    return html`<label class=${`d${String(scope.depth)}`}
        ><span>${scope.name}</span
        ><select @change=${onLevelChange}>${renderOptions(choices, shown)}</select></label
      >
      ${map(scope.extras, (right) => this.renderExtra(scope, right))}`;
  }

  private renderExtra(scope: TokenScope, right: ExtraRight): TemplateResult {
    const inherited = inheritsExtra(this.permissions, scope, right);
    const onChange = (event: Event): void => {
      if (!(event.target instanceof HTMLInputElement)) return;
      this.permissions = withExtra(this.permissions, scope, right, event.target.checked);
      this.errors = { ...this.errors, rights: "" };
    };
    return html`<label class=${`d${String(scope.depth)}`}
      ><span>${scope.name}: ${EXTRA_RIGHT_NAMES[right]}</span
      ><input
        type="checkbox"
        .checked=${inherited || givesExtra(this.permissions, scope, right)}
        ?disabled=${inherited}
        @change=${onChange}
    /></label>`;
  }

  private setLevel(scope: TokenScope, level: AccessLevel): void {
    this.permissions = withLevel(this.permissions, scope, level);
    this.errors = { ...this.errors, rights: "" };
  }

  private endDateProblem(endsUs: number): string {
    const now = Date.now() * 1000;
    if (Number.isNaN(endsUs) || endsUs <= now) return msg("Choose a day that is not over.");
    return endsUs > now + (MOST_DAYS + 1) * DAY_US ? msg("Choose a day within a year.") : "";
  }

  private clock(): ZoneClock {
    return new ZoneClock(knownZone(this.zone));
  }

  private readonly onCancel = (): void => {
    this.dispatchEvent(new CustomEvent("t-cancel"));
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    if (this.busy) return;
    const name = this.name.value.trim();
    const clock = this.clock();
    const endsUs = clock.dayAfter(clock.fromInput(`${this.ends.value}T12:00:00`), 1);
    const some = (this.person?.permissions.length ?? 0) === 0 || this.permissions.length > 0;
    this.errors = {
      name: name === "" ? msg("Enter a name.") : "",
      ends: this.endDateProblem(endsUs),
      rights: some ? "" : msg("Give it at least one right; without, it is of no use."),
    };
    if (Object.values(this.errors).some((error) => error !== "")) return;
    const detail: TokenWish = { name, endsUs: Math.round(endsUs), permissions: this.permissions };
    this.dispatchEvent(new CustomEvent("t-wish", { detail }));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-token-form": TokenForm;
  }
  interface GlobalEventHandlersEventMap {
    "t-wish": CustomEvent<TokenWish>;
  }
}
