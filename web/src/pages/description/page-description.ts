/** The description of a site: what counts now, what counted before, and the way to change it. */

import { consume } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { adviceFor, type Advice } from "../../format/error-advice.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { DescriptionsApi, type ChangeAnswer, type DescriptionList, type DifferenceAnswer, type Version } from "../../wire/descriptions-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice, renderLoadError } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/feedback/confirm.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "../admin-tabs.js";
import "./description-diff.js";
import "./description-editor.js";
import "./description-problems.js";

const ACCEPTS: Readonly<Record<string, string>> = {
  no: "The gateway takes no changes from here. Start it with --accept-changes readings, or change its file there: it follows at once.",
  readings: "The gateway accepts changes to what is read and shown; everything else is changed in its own file.",
  all: "The gateway takes changes, but for how the robot is reached and what runs beside it.",
};
const PAGES = [
  { id: "versions", label: "Versions" },
  { id: "edit", label: "Edit" },
];

@customElement("t-page-description")
export class PageDescription extends LitElement {
  static override styles = [
    base,
    sheets,
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
        min-block-size: var(--t-touch);
        max-inline-size: 100%;
        padding-inline: var(--t-space-3);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
      }
      code {
        font-family: var(--t-mono);
        font-size: var(--t-size-s);
      }
    `,
  ];

  /** Set by the frame for every page; this one is of no single site. */
  @property() site = "";

  @state() private chosen = "";
  @state() private page = "versions";
  @state() private shown: Version | null = null;
  @state() private backTo: Version | null = null;
  @state() private answer: ChangeAnswer | null = null;
  @state() private older: readonly Version[] = [];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly known = new LoadController<DescriptionList>(this);
  private readonly difference = new LoadController<DifferenceAnswer>(this);
  private readonly action = new ActionController(this);
  private edition = "";

  /** The site that is shown: the one that was chosen, or the first. */
  private get siteId(): string {
    return this.chosen || (this.sites.store?.list[0]?.site ?? "");
  }

  override willUpdate(): void {
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
    const known = this.known.value;
    return html`<t-admin-tabs page="description"></t-admin-tabs>
      <div class="head">
        <div>
          <h1>Description</h1>
          <p class="muted">Everything that defines a site. The gateway's own copy is the one in use.</p>
        </div>
        ${sites.length < 2
          ? nothing
          : html`<select aria-label="Site" @change=${this.onChoose}>
              ${map(sites, (row) => html`<option value=${row.site} ?selected=${row.site === this.siteId}>${row.name}</option>`)}
            </select>`}
      </div>
      ${this.siteId === "" && this.sites.store !== undefined
        ? html`<t-empty heading="No site is known yet" icon="info"><p>A site appears here once its gateway has connected.</p></t-empty>`
        : nothing}
      ${renderLoadError(this.known.result, "the site's description", this.retry)} ${known === undefined ? this.renderLoading() : this.renderContent(known)}`;
  }

  private renderLoading(): unknown {
    if (this.known.result.state === "failed" || this.siteId === "") return nothing;
    return html`<t-loading what="Loading the description"></t-loading>`;
  }

  private renderContent(known: DescriptionList): TemplateResult {
    const newest = known.versions[0];
    return html`<section class="sheet" aria-label="Current version">
        <div class="now">
          <t-status kind=${known.online ? "ok" : "offline"} word=${known.online ? "in use" : "gateway offline"}></t-status>
          ${newest === undefined ? nothing : html`<span>version ${newest.number}, since <t-time us=${newest.time_us} zone=${known.zone}></t-time></span>`}
        </div>
        ${known.online ? html`<p class="muted">${ACCEPTS[known.accepts] ?? "This gateway does not say whether it takes changes."}</p>` : nothing}
        ${known.problem === ""
          ? nothing
          : html`<t-problem what="The file at the gateway was changed and is not valid. The previous version stays in use." how=${known.problem}></t-problem>
              <t-findings .findings=${known.findings}></t-findings>`}
      </section>
      <t-choice label="What to do" .options=${PAGES} chosen=${this.page} @t-choose=${this.onTabChange}></t-choice>
      ${this.page === "edit"
        ? html`<t-description-editor .site=${this.siteId} .known=${known} @t-applied=${this.retry}></t-description-editor>`
        : this.renderVersions(known)}`;
  }

  private renderVersions(known: DescriptionList): TemplateResult {
    const rows = [...known.versions, ...this.older];
    const more = this.older.length === 0 ? known.more : (rows.at(-1)?.number ?? 1) > 1;
    return html`<section class="sheet" aria-label="Versions">
        <ul class="rows">
          ${repeat(
            rows,
            (row) => row.number,
            (row) => this.renderRow(row, known),
          )}
        </ul>
        ${more ? html`<div class="actions"><t-button ?busy=${this.action.runningKey === "older"} @click=${this.showOlder}>Older versions</t-button></div>` : nothing}
      </section>
      ${this.renderConfirm(known)}`;
  }

  private renderRow(row: Version, known: DescriptionList): TemplateResult {
    const open = this.shown?.number === row.number;
    return html`<li>
      <div>
        <div class="name">Version ${row.number} ${row.current ? html`<span class="chip">now</span>` : nothing}</div>
        <div class="facts">
          <t-time us=${row.time_us} zone=${known.zone}></t-time>
          <span>${row.who === "" ? row.note : `${row.who} · ${row.note}`}</span>
          <span>gateway ${row.gateway}</span>
          <span title=${row.digest}>SHA-256 <code>${row.digest.slice(0, 12)}…</code></span>
        </div>
      </div>
      <div class="ways">
        ${this.previousVersion(row) === 0
          ? nothing
          : html`<t-button label=${`What changed in version ${String(row.number)}`} @click=${this.versionOpener(row)}
              >${open ? "Hide" : "What changed"}</t-button
            >`}
        ${row.current
          ? nothing
          : html`<t-button ?disabled=${!known.editable} label=${`Go back to version ${String(row.number)}`} @click=${this.restoreAsker(row)}
              >Go back to this one</t-button
            >`}
      </div>
      ${open ? html`<div class="whole">${this.renderDifferences()}</div>` : nothing}
    </li>`;
  }

  private renderDifferences(): unknown {
    const { result, value } = this.difference;
    if (result.state === "failed") {
      return renderAdvice(adviceFor(result.error, "what changed"));
    }
    if (result.state !== "ready" || value === undefined) return html`<t-loading what="Comparing"></t-loading>`;
    return html`<t-difference .parts=${value.parts} .lines=${value.lines}></t-difference>
      ${value.long ? html`<p class="muted">There are more lines than are shown.</p>` : nothing}`;
  }

  private renderConfirm(known: DescriptionList): TemplateResult {
    const { answer, backTo } = this;
    return html`<t-confirm
      ?open=${backTo !== null}
      heading=${`Go back to version ${String(backTo?.number ?? 0)}?`}
      action=${this.action.busy ? "The gateway changes over…" : "Go back to this one"}
      ?busy=${this.action.busy}
      .problem=${this.action.problem ?? refusalAdvice(answer)}
      @t-confirm=${this.versionRestorer(known)}
      @t-close=${this.closeQuestion}
    >
      <p>The gateway applies it at once, without a restart. What is the same in both continues without a break.</p>
      <p>A device that differs is stopped first, and its driver loses control.</p>
      ${answer === null || answer.findings.length === 0 ? nothing : html`<t-findings .findings=${answer.findings}></t-findings>`}
    </t-confirm>`;
  }

  /** The version before one, 0 if it is the first. */
  private previousVersion(row: Version): number {
    return row.number - 1;
  }

  private readonly onChoose = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.chosen = event.target.value;
    this.shown = null;
  };

  private readonly onTabChange = (event: CustomEvent<string>): void => {
    this.page = event.detail;
  };

  private readonly retry = (): void => {
    this.known.invalidate();
  };

  private readonly showOlder = (): void => {
    const last = [...(this.known.value?.versions ?? []), ...this.older].at(-1);
    if (last === undefined) return;
    void this.action.run(
      "list older versions",
      async () => {
        const found = await new DescriptionsApi(this.api).listVersions(this.siteId, last.number);
        this.older = [...this.older, ...found.versions];
      },
      "",
      "older",
    );
  };

  private versionOpener(row: Version): () => void {
    return () => {
      this.shown = this.shown?.number === row.number ? null : row;
    };
  }

  private restoreAsker(row: Version): () => void {
    return () => {
      this.action.clear();
      this.answer = null;
      this.backTo = row;
    };
  }

  private readonly closeQuestion = (): void => {
    this.backTo = null;
  };

  private versionRestorer(known: DescriptionList): () => void {
    return () => {
      const row = this.backTo;
      if (row === null) return;
      this.answer = null;
      const api = new DescriptionsApi(this.api);
      void this.action
        .run(`go back to version ${String(row.number)}`, async () => {
          this.answer = await api.restoreVersion(this.siteId, row.number, known.digest);
        })
        .then((done) => {
          if (done && this.answer?.phase === "applied") this.backTo = null;
          this.known.invalidate();
        });
    };
  }
}

/** What a gateway's answer means; null when there is nothing to say. */
export function refusalAdvice(answer: ChangeAnswer | null): Advice | null {
  if (answer === null || answer.phase === "applied") return null;
  const what = answer.phase === "refused" ? "The gateway refused it." : "It is not known whether it was done.";
  return { what, how: answer.message };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-description": PageDescription;
  }
}
