/** The description of a site: what counts now, what counted before, and the way to change it. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { QuestionController } from "../../controllers/question.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { DescriptionsApi } from "../../wire/descriptions-api.js";
import type { ChangeAnswer, DescriptionList, DifferenceAnswer, VersionShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { hubText } from "../../words/hub-text.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "../admin-tabs.js";
import { readNewSensor, type NewSensor } from "./new-sensor.js";
import { refusalAdvice } from "./refusal-advice.js";
import "./description-diff.js";
import "./description-editor.js";
import "./description-problems.js";

const ACCEPTS: Readonly<Record<string, string>> = {
  no: msg("The gateway takes no changes from here. Start it with --accept-changes readings, or change its file there: it follows at once."),
  readings: msg("The gateway accepts changes to what is read and shown; everything else is changed in its own file."),
  all: msg("The gateway takes changes, but for how the robot is reached and what runs beside it."),
};
const PAGES = [
  { id: "versions", label: msg("Versions") },
  { id: "edit", label: msg("Edit") },
];

@customElement("t-page-description")
export class PageDescription extends LitElement {
  static override styles = [
    base,
    sheets,
    control,
    css`
      .now {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-4);
      }
      .ways {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-2);
      }
      t-choice {
        justify-self: start;
      }
      .whole {
        grid-column: 1 / -1;
      }
      select {
        max-inline-size: 100%;
      }
    `,
  ];

  /** Set by the frame for every page; this one is of no single site. */
  @property() site = "";

  /** What the address asks to add, and the address that was read. */
  private sensor: NewSensor | null = null;
  private search = "";
  @state() private chosen = "";
  @state() private page = "versions";
  @state() private shown: VersionShape | null = null;
  @state() private answer: ChangeAnswer | null = null;
  @state() private older: readonly VersionShape[] = [];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly known = new LoadController<DescriptionList>(this);
  private readonly difference = new LoadController<DifferenceAnswer>(this);
  private readonly action = new ActionController(this);
  private readonly restoring = new QuestionController<VersionShape>(this, (row, action) => this.restoreVersion(row, action));
  private edition = "";

  /** The site that is shown: the one that was chosen, or the first. */
  private get siteId(): string {
    return this.chosen || (this.sites.store?.list[0]?.site ?? "");
  }

  override willUpdate(): void {
    const search = this.router.store?.search ?? "";
    if (search !== this.search) {
      this.search = search;
      this.sensor = readNewSensor(search);
      if (this.sensor !== null) {
        this.chosen = this.sensor.site;
        this.page = "edit";
      }
    }
    const site = this.siteId;
    if (site === "") return;
    const edition = `${site} ${this.sites.store?.catalogueOf(site) ?? ""} ${String(this.sites.store?.siteRow(site)?.online ?? false)}`;
    if (edition !== this.edition) {
      this.edition = edition;
      this.older = [];
    }
    this.known.load(edition, () => new DescriptionsApi(this.api).listVersions(site));
    const { shown } = this;
    if (shown !== null) {
      const before = this.previousVersion(shown);
      this.difference.load(`${edition} ${String(shown.number)}`, () => new DescriptionsApi(this.api).difference(site, before, shown.number));
    }
  }

  override render(): TemplateResult {
    const sites = this.sites.store?.list ?? [];
    return html`<t-admin-tabs page="description"></t-admin-tabs>
      ${renderPageHead(
        msg("Description"),
        msg("Everything that defines a site. The gateway's own copy is the one in use."),
        sites.length < 2
          ? nothing
          : html`<select aria-label=${msg("Site")} @change=${this.onChoose}>${renderOptions(sites.map(({ site, name }) => [site, name]), this.siteId)}</select>`,
      )}
      ${this.siteId === "" && this.sites.store !== undefined
        ? html`<t-empty heading=${msg("No site is known yet")} icon="info"><p>${msg("A site appears here once its gateway has connected.")}</p></t-empty>`
        : nothing}
      ${this.siteId === "" ? nothing : renderLoaded(this.known, msg("the site's description"), (known) => this.renderContent(known))}`;
  }

  private renderContent(known: DescriptionList): TemplateResult {
    const newest = known.versions[0];
    return html`<section class="sheet" aria-label=${msg("Current version")}>
        <div class="now">
          <t-status kind=${known.online ? "ok" : "offline"} word=${known.online ? msg("in use") : msg("gateway offline")}></t-status>
          ${newest === undefined ? nothing : html`<span>${msg(html`version ${newest.number}, since <t-time us=${newest.time_us} zone=${known.zone}></t-time>`)}</span>`}
        </div>
        ${known.online ? html`<p class="muted">${ACCEPTS[known.accepts] ?? msg("This gateway does not say whether it takes changes.")}</p>` : nothing}
        ${known.problem === ""
          ? nothing
          : html`<t-problem what=${msg("The file at the gateway was changed and is not valid. The previous version stays in use.")} how=${known.problem}></t-problem>
              <t-findings .findings=${known.findings}></t-findings>`}
      </section>
      <t-choice label=${msg("What to do")} .options=${PAGES} chosen=${this.page} @t-choose=${this.onTabChange}></t-choice>
      ${this.page === "edit"
        ? html`<t-description-editor .site=${this.siteId} .known=${known} .sensor=${this.sensor} @t-applied=${this.known.invalidate}></t-description-editor>`
        : this.renderVersions(known)}`;
  }

  private renderVersions(known: DescriptionList): TemplateResult {
    const rows = [...known.versions, ...this.older];
    const more = this.older.length === 0 ? known.more : (rows.at(-1)?.number ?? 1) > 1;
    return html`<section class="sheet" aria-label=${msg("Versions")}>
        <ul class="rows">
          ${repeat(rows, ({ number }) => number, (row) => this.renderRow(row, known))}
        </ul>
        ${more ? html`<div class="actions"><t-button ?busy=${this.action.runningKey === "older"} @click=${this.showOlder}>${msg("Older versions")}</t-button></div>` : nothing}
      </section>
      ${this.renderConfirm()}`;
  }

  private renderRow(row: VersionShape, known: DescriptionList): TemplateResult {
    const open = this.shown?.number === row.number;
    return html`<li>
      <div>
        <div class="name">${msg(str`Version ${row.number}`)} ${row.current ? html`<span class="chip">${msg("now")}</span>` : nothing}</div>
        <div class="facts">
          <t-time us=${row.time_us} zone=${known.zone}></t-time>
          <span>${row.who === "" ? hubText(row.note) : `${row.who} · ${row.note}`}</span>
          <span>${msg(str`gateway ${row.gateway}`)}</span>
          <span title=${row.digest}>${msg(html`SHA-256 <code>${row.digest.slice(0, 12)}…</code>`)}</span>
        </div>
      </div>
      <div class="ways">
        ${this.previousVersion(row) === 0
          ? nothing
          : html`<t-button label=${msg(str`What changed in version ${String(row.number)}`)} @click=${this.versionOpener(row)}
              >${open ? msg("Hide") : msg("What changed")}</t-button
            >`}
        ${row.current
          ? nothing
          : html`<t-button ?disabled=${!known.editable} label=${msg(str`Go back to version ${String(row.number)}`)} @click=${this.restoreAsker(row)}
              >${msg("Go back to this one")}</t-button
            >`}
      </div>
      ${open ? html`<div class="whole">${this.renderDifferences()}</div>` : nothing}
    </li>`;
  }

  private renderDifferences(): unknown {
    // Those of the version before are of no use here.
    if (this.difference.result.state === "loading") return html`<t-loading what=${msg("Comparing")}></t-loading>`;
    return renderLoaded(
      this.difference,
      msg("what changed"),
      ({ parts, lines, long }) =>
        html`<t-difference .parts=${parts} .lines=${lines}></t-difference>
          ${long ? html`<p class="muted">${msg("There are more lines than are shown.")}</p>` : nothing}`,
    );
  }

  private renderConfirm(): TemplateResult {
    const { answer } = this;
    return renderQuestion(this.restoring, ({ number }) => ({
      heading: msg(str`Go back to version ${String(number)}?`),
      action: this.restoring.action.busy ? msg("The gateway changes over…") : msg("Go back to this one"),
      problem: refusalAdvice(answer),
      text: html`<p>${msg("The gateway applies it at once, without a restart. What is the same in both continues without a break.")}</p>
        <p>${msg("A device that differs is stopped first, and its driver loses control.")}</p>
        ${answer === null || answer.findings.length === 0 ? nothing : html`<t-findings .findings=${answer.findings}></t-findings>`}`,
    }));
  }

  /** The version before one, 0 if it is the first. */
  private previousVersion(row: VersionShape): number {
    return row.number - 1;
  }

  private readonly onChoose = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.chosen = event.target.value;
    this.shown = null;
  };

  private readonly onTabChange = (event: CustomEvent<string>): void => {
    this.page = event.detail;
  };

  private readonly showOlder = (): void => {
    const last = [...(this.known.value?.versions ?? []), ...this.older].at(-1);
    if (last === undefined) return;
    void this.action.run(
      msg("list older versions"),
      async () => {
        const found = await new DescriptionsApi(this.api).listVersions(this.siteId, last.number);
        this.older = [...this.older, ...found.versions];
      },
      "",
      "older",
    );
  };

  private versionOpener(row: VersionShape): () => void {
    return () => {
      this.shown = this.shown?.number === row.number ? null : row;
    };
  }

  private restoreAsker(row: VersionShape): (event: Event) => void {
    return (event) => {
      this.answer = null;
      this.restoring.opener(row)(event);
    };
  }

  /** Gives whether the gateway changed over. */
  private async restoreVersion(row: VersionShape, action: ActionController): Promise<boolean> {
    const digest = this.known.value?.digest ?? "";
    this.answer = null;
    const asked = await action.run(msg(str`go back to version ${String(row.number)}`), async () => {
      this.answer = await new DescriptionsApi(this.api).restoreVersion(this.siteId, row.number, digest);
    });
    this.known.invalidate();
    return asked && (this.answer as ChangeAnswer | null)?.phase === "applied";
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-description": PageDescription;
  }
}
