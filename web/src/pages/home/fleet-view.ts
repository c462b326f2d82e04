/** Many sites at once: search, tags, order and groups over cards, of which only those near the view are drawn. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query as queried, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base, plainList } from "../../elements/base/base-style.js";
import { control } from "../../elements/forms/input-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import type { SiteSummary } from "../../generated/api.js";
import { alarmsContext } from "../../state/contexts.js";
import { NO_TROUBLE, troublesOf, type SiteTrouble } from "../../tiles/site-trouble.js";
import { fleetGroups, FLEET_ORDERS, isFleetOrder, tagsOf, type FleetGroup, type FleetQuery } from "./fleet-list.js";
import { ShownRowsController } from "./shown-rows.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/button.js";
import "../../tiles/fleet-card.js";

/** Which order was chosen stays in the browser. */
const KEY = "talaia.fleet-order";

@customElement("t-fleet-view")
export class FleetView extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-4);
      }
      .tools {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-2);
      }
      .tools > * {
        flex: 1 1 auto;
        max-inline-size: 100%;
      }
      .tools input {
        flex: 4 1 14rem;
      }
      section {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-2);
      }
      ul {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(22rem, 100%), 1fr));
        gap: var(--t-space-3);
        ${plainList}
      }
      li {
        /* What is far from the view costs no layout. */
        content-visibility: auto;
        contain-intrinsic-size: auto 6.5rem;
      }
      t-fleet-card {
        block-size: 100%;
      }
    `,
  ];

  @property({ attribute: false }) rows: readonly SiteSummary[] = [];
  @state() private query: FleetQuery = { words: "", tag: "", order: keptOrder() };
  @queried(".end") private readonly end!: HTMLElement | null;
  private readonly shown = new ShownRowsController(this, () => this.end);

  private readonly alarms = new ContextStoreController(this, alarmsContext);

  override render(): TemplateResult {
    const { rows, query } = this;
    const troubles = troublesOf(this.alarms.store);
    const groups = fleetGroups(rows, query, troubles);
    const found = groups.reduce((sum, group) => sum + group.rows.length, 0);
    return html`
      <div class="tools" role="search">
        <input type="search" placeholder=${msg("Search names, tags, states")} aria-label=${msg("Search sites")} .value=${query.words} @input=${this.onWords} />
        ${tagsOf(rows).length === 0
          ? nothing
          : html`<select aria-label=${msg("Tag")} @change=${this.onTag}>${renderOptions([["", msg("All tags")], ...tagsOf(rows).map((tag) => [tag, tag] as const)], query.tag)}</select>`}
        <select aria-label=${msg("Order")} @change=${this.onOrder}>${renderOptions(FLEET_ORDERS, query.order)}</select>
      </div>
      <p class="muted" role="status">${found === rows.length ? nothing : msg(str`${String(found)} of ${String(rows.length)} sites`)}</p>
      ${found === 0
        ? html`<t-empty heading=${msg("No site fits")} icon="devices"><t-button @click=${this.onClear}>${msg("Show all")}</t-button></t-empty>`
        : this.renderGroups(groups, troubles)}
    `;
  }

  private renderGroups(groups: readonly FleetGroup[], troubles: ReadonlyMap<string, SiteTrouble>): unknown {
    const { drawn, ends } = this.shown.firstOf(groups);
    const sections = drawn.map(({ group: { name, rows: all }, rows }) => {
      const heading = name !== "" ? name : groups.length > 1 ? msg("In no group") : "";
      return html`<section>
        ${heading === "" ? html`<h2 class="visually-hidden">${msg("Sites")}</h2>` : html`<h2>${heading} <span class="muted">${all.length}</span></h2>`}
        <ul>
          ${repeat(
            rows,
            ({ site }) => site,
            (row) => {
              const { bad, warn } = troubles.get(row.site) ?? NO_TROUBLE;
              return html`<li><t-fleet-card .row=${row} .bad=${bad} .warn=${warn} ?plain=${row.stream === ""}></t-fleet-card></li>`;
            },
          )}
        </ul>
      </section>`;
    });
    return html`${sections}${ends ? html`<div class="end"></div>` : nothing}`;
  }

  private readonly onWords = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.changeQuery({ words: event.target.value });
  };

  private readonly onTag = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.changeQuery({ tag: event.target.value });
  };

  private readonly onOrder = (event: Event): void => {
    if (!(event.target instanceof HTMLSelectElement) || !isFleetOrder(event.target.value)) return;
    localStorage.setItem(KEY, event.target.value);
    this.changeQuery({ order: event.target.value });
  };

  private readonly onClear = (): void => {
    this.changeQuery({ words: "", tag: "" });
  };

  private changeQuery(change: Partial<FleetQuery>): void {
    this.query = { ...this.query, ...change };
    this.shown.restart();
  }
}

function keptOrder(): FleetQuery["order"] {
  const kept = localStorage.getItem(KEY) ?? "";
  return isFleetOrder(kept) ? kept : "trouble";
}

declare global {
  interface HTMLElementTagNameMap {
    "t-fleet-view": FleetView;
  }
}
