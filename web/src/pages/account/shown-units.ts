/** In which units one wants to see values: one's own choice, before the site's. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { AccountApi } from "../../wire/account-api.js";
import type { UnitChoice } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { ENGLISH, shownLanguage } from "../../words/locale.js";
import "../../elements/forms/field.js";

@customElement("t-account-units")
export class AccountUnits extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .units {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(14rem, 100%), 1fr));
        gap: var(--t-space-3) var(--t-space-4);
      }
    `,
  ];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  /** What was chosen here since the page was opened, by stored unit. */
  @state() private chosen: ReadonlyMap<string, string> = new Map();
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly known = new LoadController<readonly UnitChoice[]>(this);
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    this.known.load("units", () => new AccountApi(this.api).units());
  }

  override render(): TemplateResult {
    return html`<h2>${msg("Units")}</h2>
      <p class="muted">${msg("How pages show values to you. Limits that you type, exports and scripts stay in the unit in which a value is stored.")}</p>
      ${renderAdvice(this.action.problem)}
      <p class="visually-hidden" role="status">${this.action.doneText}</p>
      ${renderLoaded(this.known, msg("the units of your sites"), (known) =>
        known.length === 0
          ? html`<p class="muted">${msg("No value that you may see has a unit that could be shown in another.")}</p>`
          : html`<div class="units">${map(known, (choice) => this.renderChoice(choice, known))}</div>`,
      )}`;
  }

  private renderChoice({ unit, name, sites, choices, shown }: UnitChoice, known: readonly UnitChoice[]): TemplateResult {
    const now = this.chosen.get(unit) ?? shown;
    const options = [["", msg("as the site has it")], [unit, msg(str`${unit}, as stored`)], ...choices.map((other) => [other, other] as const)] as const;
    return html`<t-field label=${name === unit || shownLanguage() !== ENGLISH ? unit : `${name} (${unit})`} hint=${sites.join(", ")}>
      <select data-unit=${unit} ?disabled=${this.action.busy} @change=${this.chooser(unit, known)}>${renderOptions(options, now)}</select>
    </t-field>`;
  }

  private chooser(unit: string, known: readonly UnitChoice[]): (event: Event) => void {
    return (event) => {
      const wanted = (event.target as HTMLSelectElement).value;
      void this.choose(new Map([...this.chosen, [unit, wanted]]), known);
    };
  }

  private async choose(chosen: ReadonlyMap<string, string>, known: readonly UnitChoice[]): Promise<void> {
    const all = new Map([...known.map(({ unit, shown }) => [unit, shown] as const), ...chosen]);
    const shown = Object.fromEntries([...all].filter(([, wanted]) => wanted !== ""));
    const before = this.chosen;
    this.chosen = chosen;
    const done = await this.action.run(msg("change the unit"), () => new AccountApi(this.api).chooseUnits(shown), msg("Values are shown so from now on."));
    // What the hub did not take is not shown as if it had.
    if (done) this.sites.store?.forgetDetails();
    else this.chosen = before;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-units": AccountUnits;
  }
}
