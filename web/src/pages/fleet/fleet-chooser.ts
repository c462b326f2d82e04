/** Which sites a group is made of: by a tick each, or all that a search or a tag finds. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { base, plainList, quietText } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import type { SiteSummary } from "../../generated/api.js";
import { renderStanding } from "../../tiles/site-glance.js";
import type { SiteTrouble } from "../../tiles/site-trouble.js";
import { fleetGroups, tagsOf, type FleetGroup } from "../home/fleet-list.js";
import { ShownRowsController } from "../home/shown-rows.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/button.js";

const NO_TROUBLES: ReadonlyMap<string, SiteTrouble> = new Map();

/** @fires t-choose-sites detail are the ids of all sites that are chosen now */
@customElement("t-fleet-chooser")
export class FleetChooser extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
      .tools {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-2);
      }
      .tools input {
        flex: 4 1 12rem;
      }
      .tools select {
        flex: 1 1 8rem;
        max-inline-size: 100%;
      }
      fieldset {
        display: grid;
        gap: var(--t-space-1);
        min-inline-size: 0;
        margin: 0;
        padding: 0;
        border: 0;
      }
      legend {
        padding: 0;
        font-weight: var(--t-weight-strong);
      }
      ul {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(18rem, 100%), 1fr));
        gap: 0 var(--t-space-4);
        ${plainList}
      }
      li {
        content-visibility: auto;
        contain-intrinsic-size: auto 2.75rem;
      }
      label {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr) auto;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: var(--t-touch);
        cursor: pointer;
        overflow-wrap: anywhere;
      }
      input[type="checkbox"] {
        inline-size: 1.25rem;
        block-size: 1.25rem;
        accent-color: var(--t-accent);
      }
      .facts {
        ${quietText}
      }
    `,
  ];

  @property({ attribute: false }) rows: readonly SiteSummary[] = [];
  @property({ attribute: false }) chosen: ReadonlySet<string> = new Set();
  @state() private words = "";
  @state() private tag = "";
  @query(".end") private readonly end!: HTMLElement | null;
  private readonly link = new ConnectionStateController(this);
  private readonly shown = new ShownRowsController(this, () => this.end);

  override render(): TemplateResult {
    const { rows } = this;
    const groups = this.foundGroups();
    const found = sitesOf(groups);
    const tags = tagsOf(rows);
    return html`
      <div class="tools" role="search">
        <input type="search" placeholder=${msg("Search names, tags, states")} aria-label=${msg("Search sites")} .value=${this.words} @input=${this.onWords} />
        ${tags.length === 0 ? nothing : html`<select aria-label=${msg("Tag")} @change=${this.onTag}>${renderOptions([["", msg("All tags")], ...tags.map((tag) => [tag, tag] as const)], this.tag)}</select>`}
        <t-button ?disabled=${found.length === 0} @click=${this.chooseFound}>${msg(str`Choose all ${found.length}`)}</t-button>
        <t-button ?disabled=${this.chosen.size === 0} @click=${this.chooseNone}>${msg("Choose none")}</t-button>
      </div>
      ${found.length === 0 ? html`<t-empty heading=${msg("No site fits")} icon="devices"></t-empty>` : this.renderGroups(groups)}
    `;
  }

  /** Rows near the view alone: what a row is made of takes time a thousand times. */
  private renderGroups(groups: readonly FleetGroup[]): TemplateResult {
    const { drawn, ends } = this.shown.firstOf(groups);
    const sections = drawn.map(({ group: { name }, rows }) => this.renderGroup(name || (groups.length > 1 ? msg("In no group") : msg("Sites")), rows));
    return html`${sections}${ends ? html`<div class="end"></div>` : nothing}`;
  }

  private foundGroups(): readonly FleetGroup[] {
    return fleetGroups(this.rows, { words: this.words, tag: this.tag, order: "name" }, NO_TROUBLES);
  }

  private renderGroup(name: string, rows: readonly SiteSummary[]): TemplateResult {
    return html`<fieldset>
      <legend>${name}</legend>
      <ul>
        ${repeat(
          rows,
          ({ site }) => site,
          ({ site, name: shown, online, state, tags }) => html`<li>
            <label>
              <input type="checkbox" name=${site} .checked=${this.chosen.has(site)} @change=${this.onTick} />
              <span>${shown} <span class="facts">${[state, ...tags.map((tag) => `#${tag}`)].filter(Boolean).join(" · ")}</span></span>
              ${renderStanding({ online }, this.link.state)}
            </label>
          </li>`,
        )}
      </ul>
    </fieldset>`;
  }

  private readonly onTick = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    const { name, checked } = event.target;
    this.choose(checked ? [...this.chosen, name] : [...this.chosen].filter((site) => site !== name));
  };

  private readonly onWords = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    this.words = event.target.value;
    this.shown.restart();
  };

  private readonly onTag = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.tag = event.target.value;
  };

  private readonly chooseFound = (): void => {
    this.choose([...this.chosen, ...sitesOf(this.foundGroups())]);
  };

  private readonly chooseNone = (): void => {
    this.choose([]);
  };

  private choose(sites: readonly string[]): void {
    this.dispatchEvent(new CustomEvent<readonly string[]>("t-choose-sites", { detail: [...new Set(sites)] }));
  }
}

function sitesOf(groups: readonly FleetGroup[]): readonly string[] {
  return groups.flatMap(({ rows }) => rows.map(({ site }) => site));
}

declare global {
  interface HTMLElementTagNameMap {
    "t-fleet-chooser": FleetChooser;
  }
  interface GlobalEventHandlersEventMap {
    "t-choose-sites": CustomEvent<readonly string[]>;
  }
}
