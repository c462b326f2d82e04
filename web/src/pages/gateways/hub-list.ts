/** The hubs that are one: which leads, how each is, and what is wrong. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRows } from "../../elements/layout/rows.js";
import { plural } from "../../words/plural.js";
import type { HubList, HubShape, ShardShape } from "../../generated/api.js";
import type { StatusKind } from "../../elements/feedback/status.js";
import { hubFacts } from "./hub-facts.js";
import "../../elements/feedback/banner.js";
import "../../elements/feedback/status.js";

const ROLES: Readonly<Record<string, readonly [StatusKind, string]>> = {
  leads: ["online", msg("leads")],
  waits: ["ok", msg("waits")],
  leaves: ["busy", msg("leaves")],
  gone: ["offline", msg("gone")],
};

@customElement("t-hub-list")
export class HubListView extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      :host([hidden]) {
        display: none;
      }
      .facts {
        font-variant-numeric: tabular-nums;
      }
      .facts details,
      .facts summary {
        display: inline-block;
        margin: 0;
        padding: 0;
        font-weight: inherit;
      }
    `,
  ];

  @property({ attribute: false }) list: HubList | null = null;

  override render(): TemplateResult | typeof nothing {
    const { list } = this;
    // One that is alone has nothing to say here.
    if (list?.clustered !== true) return nothing;
    return html`<section class="sheet" aria-label=${msg("Hubs")}>
      <h2>${msg("Hubs")}</h2>
      ${map(list.problems, (problem) => html`<t-banner kind="warn">${problem}.</t-banner>`)}
      ${renderRows(
        list.hubs.map((hub) => ({ ...hub, id: hub.name })),
        (hub) => renderHub(hub),
      )}
      ${list.shards.length === 0 ? nothing : renderShards(list.shards)}
    </section>`;
  }
}

function renderShards(shards: readonly ShardShape[]): TemplateResult {
  return html`<h3>${msg("Shards")}</h3>
    ${renderRows(
      shards.map((shard) => ({ ...shard, id: shard.name })),
      (shard) => renderShard(shard),
    )}`;
}

function renderShard(shard: ShardShape): TemplateResult {
  const count = shard.sites.length;
  return html`<li>
    <div>
      <span class="name">${shard.name}</span>
      <div class="facts">
        <span>${shard.lead === "" ? msg("no hub leads it") : msg(str`led by ${shard.lead}`)}</span>
        ${
          count === 0
            ? html`<span>${msg("no sites")}</span>`
            : html`<details>
                <summary>${plural(count, msg("1 site"), msg(str`${String(count)} sites`))}</summary>
                ${shard.sites.join(", ")}
              </details>`
        }
      </div>
    </div>
    <t-status kind=${shard.lead === "" ? "offline" : "online"} word=${shard.lead === "" ? msg("no lead") : msg("led")}></t-status>
  </li>`;
}

function renderHub(hub: HubShape): TemplateResult {
  const [kind, word] = ROLES[hub.role] ?? ["unknown", hub.role];
  return html`<li>
    <div>
      <span class="name">${hub.name}</span>
      <div class="facts">${map(hubFacts(hub, Date.now() * 1000), (fact) => html`<span>${fact}</span>`)}</div>
    </div>
    <t-status kind=${kind} word=${word}></t-status>
  </li>`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-hub-list": HubListView;
  }
}
