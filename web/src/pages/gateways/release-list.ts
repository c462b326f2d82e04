/** Releases of the gateways' own software: which are there, who runs what, and handing one out. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { renderFormActions, renderOptions } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { renderRows } from "../../elements/layout/rows.js";
import { formatBytes } from "../../format/bytes.js";
import { plural } from "../../words/plural.js";
import { apiContext } from "../../state/contexts.js";
import type { GatewayReleaseShape, ReleaseList, ReleaseShape, RolloutShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { offeredVersions, phaseWords, rolloutWords, stageStatus } from "./release-words.js";
import "../../elements/feedback/banner.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/values/time.js";

/** @fires t-changed something was done: the list is old */
@customElement("t-release-list")
export class ReleaseListView extends LitElement {
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
      fieldset {
        display: grid;
        gap: var(--t-space-1);
        margin: 0;
        padding: var(--t-space-2) var(--t-space-3);
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius);
        max-block-size: 20rem;
        overflow-y: auto;
      }
      fieldset label {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: var(--t-touch);
      }
    `,
  ];

  @property({ attribute: false }) list: ReleaseList | null = null;
  /** How people call each site. */
  @property({ attribute: false }) siteNames: (site: string) => string = (site) => site;
  @property() zone = "UTC";
  @state() private version = "";
  @state() private wrong = "";
  @query("form") private readonly form!: HTMLFormElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);
  private readonly opened = new OpenSubject<"new">(this);

  override render(): TemplateResult | typeof nothing {
    const { list } = this;
    if (list === null || (list.releases.length === 0 && list.gateways.length === 0)) return nothing;
    const running = list.rollout?.runs === true;
    const ready = !running && [...offeredVersions(list).values()].some((sites) => sites.length > 0);
    return html`<section class="sheet" aria-label=${msg("Software of gateways")}>
      <div class="head">
        <h2>${msg("Software of gateways")}</h2>
        <t-button ?hidden=${!ready || this.opened.isOpen} @click=${this.opened.opener("new")}>${msg("Hand a release out")}</t-button>
      </div>
      ${renderAdvice(this.action.problem)} ${list.rollout === null ? nothing : this.renderRollout(list.rollout)}
      ${this.opened.isOpen && ready ? this.renderForm(list) : nothing} ${this.renderGateways(list)} ${this.renderReleases(list.releases)}
    </section>`;
  }

  private renderRollout(rollout: RolloutShape): TemplateResult {
    const open = rollout.sites.filter(({ stage }) => stage !== "done" || rollout.sites.length < 6);
    return html`<div class="head">
        <h3>${msg(str`Release ${rollout.version}`)}</h3>
        <t-button
          ?hidden=${!rollout.runs || rollout.stopped !== ""}
          ?busy=${this.action.runningKey === "stop"}
          @click=${this.stopRollout}
          >${msg("Stop it")}</t-button
        >
      </div>
      <p role="status">${rolloutWords(rollout)}</p>
      <p class="muted">
        ${msg(html`${rollout.who} began it <t-time .us=${rollout.began_us} .zone=${this.zone}></t-time>: first ${rollout.first}, then ${rollout.at_once} at a time, each when all before run it.`)}
      </p>
      ${renderRows(
        open.slice(0, 50).map((site) => ({ ...site, id: site.site })),
        ({ site, stage, why }) => {
          const [kind, word] = stageStatus(stage, rollout.stopped !== "");
          return html`<li>
            <div>
              <span class="name">${this.siteNames(site)}</span>
              <div class="facts">${why}</div>
            </div>
            <t-status kind=${kind} word=${word}></t-status>
          </li>`;
        },
      )}
      ${open.length > 50 ? html`<p class="muted">${msg(str`and ${open.length - 50} more`)}</p>` : nothing}`;
  }

  private renderGateways(list: ReleaseList): TemplateResult {
    if (list.gateways.length === 0) {
      return html`<p class="muted">
        ${msg(html`No gateway that is connected takes releases from this hub. One does that is started by <code>talaia update run</code> and was set up with <code>--from-hub</code>.`)}
      </p>`;
    }
    const sizes = new Map(list.releases.map((release) => [release.version, release.size]));
    return html`<details ?open=${list.gateways.length < 6}>
      <summary>${plural(list.gateways.length, msg("1 gateway takes releases from this hub"), msg(str`${String(list.gateways.length)} gateways take releases from this hub`))}</summary>
      ${renderRows(
        list.gateways.map((gateway) => ({ ...gateway, id: gateway.site })),
        (gateway) => this.renderGateway(gateway, sizes.get(gateway.candidate) ?? 0),
      )}
    </details>`;
  }

  private renderGateway(gateway: GatewayReleaseShape, total: number): TemplateResult {
    const left = Object.entries(gateway.failed);
    return html`<li>
      <div>
        <span class="name">${this.siteNames(gateway.site)}</span>
        <div class="facts">
          <span>${msg(str`runs ${gateway.current}`)}</span>
          <span>${phaseWords(gateway, total)}</span>
          ${map(left, ([version, why]) => html`<span>${msg(str`left ${version}:`)} ${why}</span>`)}
        </div>
      </div>
    </li>`;
  }

  private renderReleases(releases: readonly ReleaseShape[]): TemplateResult {
    if (releases.length === 0) {
      return html`<p class="muted">
        ${msg(html`There is no release here. Put signed releases into the folder <code>releases</code> of the hub's data.`)}
      </p>`;
    }
    return html`<details>
      <summary>${plural(releases.length, msg("1 release is on this hub"), msg(str`${String(releases.length)} releases are on this hub`))}</summary>
      ${renderRows(
        releases.map((release) => ({ ...release, id: release.name })),
        (release) => html`<li>
          <div>
            <span class="name">${release.version === "" ? release.name : release.version}</span>
            <div class="facts">
              <span>${release.site === "" ? msg("for all gateways") : msg(str`for ${this.siteNames(release.site)}`, { id: "for.sites" })}</span>
              <span>${formatBytes(release.size)}</span>
              <span><t-time .us=${release.changed_us} .zone=${this.zone}></t-time></span>
            </div>
            ${release.problem === "" ? nothing : html`<t-banner kind="warn">${release.problem}.</t-banner>`}
          </div>
        </li>`,
      )}
    </details>`;
  }

  private renderForm(list: ReleaseList): TemplateResult {
    const versions = offeredVersions(list);
    const version = versions.has(this.version) ? this.version : ([...versions.keys()][0] ?? "");
    const sites = versions.get(version) ?? [];
    return html`<form class="fields" novalidate @submit=${this.onSubmit}>
      <t-field label=${msg("Release")}>
        <select name="version" @change=${this.onVersion}>
          ${renderOptions(versions.keys(), version)}
        </select>
      </t-field>
      <fieldset>
        <legend>${msg("To", { id: "to.gateways" })}</legend>
        ${sites.length === 0 ? html`<p class="muted">${msg("All gateways run it.")}</p>` : nothing}
        ${map(sites, (site) => html`<label><input type="checkbox" name="site" .value=${site} checked /> ${this.siteNames(site)}</label>`)}
      </fieldset>
      <t-field label=${msg("First")} hint=${msg("So many try it before all others")}>
        <input name="first" type="number" min="1" max="10000" step="1" value="1" inputmode="numeric" />
      </t-field>
      <t-field label=${msg("Then, at a time")} error=${this.wrong}>
        <input name="at_once" type="number" min="1" max="10000" step="1" value="10" inputmode="numeric" />
      </t-field>
      <p class="muted">
        ${msg("Each gateway takes only what somebody whom it trusts has signed, and changes when nothing moves, no night is armed and its roof is closed. One whose link does not return goes back by itself; then nobody else gets it.")}
      </p>
      ${renderFormActions({ submit: msg("Hand it out"), busy: this.action.busy, cancel: this.opened.close })}
    </form>`;
  }

  private readonly onVersion = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.version = event.target.value;
  };

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    const data = new FormData(this.form);
    const sites = data.getAll("site").filter((site) => typeof site === "string");
    const version = data.get("version");
    const [first, atOnce] = [Number(data.get("first")), Number(data.get("at_once"))];
    this.wrong = "";
    if (sites.length === 0) this.wrong = msg("Choose at least one gateway.");
    else if (![first, atOnce].every((count) => Number.isInteger(count) && count >= 1 && count <= 10_000)) this.wrong = msg("Both are whole numbers from 1 on.");
    if (this.wrong !== "") return;
    const asked = { version: typeof version === "string" ? version : "", sites, first, at_once: atOnce };
    void this.action
      .run(msg("hand it out"), () => new AdminApi(this.api).beginRollout(asked))
      .then((done) => {
        if (!done) return;
        this.opened.close();
        this.dispatchEvent(new CustomEvent("t-changed"));
      });
  };

  private readonly stopRollout = (): void => {
    void this.action
      .run(msg("stop it"), () => new AdminApi(this.api).stopRollout(), "", "stop")
      .then(() => {
        this.dispatchEvent(new CustomEvent("t-changed"));
      });
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-release-list": ReleaseListView;
  }
}
