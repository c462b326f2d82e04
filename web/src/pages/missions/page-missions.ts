/** Missions of a site: which there are, the one that goes on, what became of the last ones, and a form to write one. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { RefreshController } from "../../controllers/refresh.js";
import { base, plainList, quietText } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { plural } from "../../words/plural.js";
import type { MissionList, MissionReading, MissionRow, MissionRunList, MissionRunShape, MissionShape, RunActAsk, SiteShape } from "../../generated/api.js";
import { apiContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { mayUse } from "../../state/rights.js";
import type { HubApi } from "../../wire/hub-api.js";
import { MissionsApi } from "./missions-api.js";
import { draftOf, emptyDraft, scheduleText, type MissionDraft } from "./mission-draft.js";
import { runStatus } from "./mission-run.js";
import "../../elements/feedback/confirm.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/problem.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";
import "./mission-form.js";
import "./mission-run.js";

/** How a run goes on is asked for anew (ms). */
const EVERY_MS = 1000;
const MOST_BYTES = 131_072;

@customElement("t-page-missions")
export class PageMissions extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      ul {
        display: grid;
        gap: var(--t-space-3);
        ${plainList}
      }
      .mission {
        display: grid;
        gap: var(--t-space-2);
        padding-block-start: var(--t-space-3);
        border-block-start: 1px solid var(--t-line);
      }
      .mission:first-child {
        padding-block-start: 0;
        border-block-start: 0;
      }
      .hindrance {
        color: var(--t-warn);
        font-size: var(--t-size-s);
      }
      .quiet {
        ${quietText}
      }
      input[type="file"] {
        display: none;
      }
    `,
  ];

  @property() site = "";
  @state() private draft: MissionDraft | null = null;
  @state() private removing: MissionRow | null = null;
  @state() private reading: MissionReading | null = null;
  @query("input[type=file]") private readonly file!: HTMLInputElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly missions = new LoadController<MissionList>(this);
  private readonly runs = new LoadController<MissionRunList>(this);
  private readonly action = new ActionController(this);
  protected readonly refresh = new RefreshController(this, EVERY_MS, () => {
    this.reload();
  });

  override willUpdate(): void {
    if (this.site === "") return;
    const catalogue = this.sites.store?.catalogueOf(this.site) ?? "";
    this.detail.load(`${this.site} ${catalogue}`, () => this.sites.store?.loadDetail(this.site) ?? this.api.site(this.site));
    this.missions.load(this.site, () => this.missionsApi.listMissions());
    this.runs.load(this.site, () => this.missionsApi.listRuns());
  }

  override render(): TemplateResult {
    const may = this.mayUse;
    return html`${renderPageHead(
        msg("Missions"),
        msg("Steps in order, by hand or at a time. Each step is asked for as a person's command: by the same rights and interlocks. STOP ends a mission."),
        may
          ? html`<div class="actions">
              <t-button kind="primary" ?disabled=${this.draft !== null} @click=${this.openNew}>${msg("New mission")}</t-button>
              <t-button @click=${this.chooseFile}>${msg("Import…")}</t-button>
              <input type="file" accept=".yaml,.yml,text/yaml" aria-label=${msg("A mission's file")} @change=${this.onFile} />
            </div>`
          : nothing,
      )}
      ${renderAdvice(this.action.problem)} ${this.renderReading()} ${this.renderForm()}
      ${renderLoaded(this.missions, msg("the missions"), (list) => this.renderList(list, may))} ${renderLoaded(this.runs, msg("the runs"), ({ runs }) => this.renderRuns(runs))} ${this.renderRemoval()}`;
  }

  private get mayUse(): boolean {
    return mayUse(this.session.store?.person, this.site, "");
  }

  private get missionsApi(): MissionsApi {
    return new MissionsApi(this.api, this.site);
  }

  private get zone(): string {
    return this.sites.store?.zoneOf(this.site) ?? "UTC";
  }

  private renderForm(): unknown {
    if (this.draft === null) return nothing;
    return html`<section class="sheet" aria-label=${msg("Mission")}>
      <h2>${this.draft.id === "" ? msg("New mission") : msg("Change the mission")}</h2>
      ${renderLoaded(this.detail, msg("the site"), (detail) => html`<t-mission-form .site=${detail} .draft=${this.draft ?? emptyDraft()} ?busy=${this.action.busy} @t-draft=${this.onDraft} @t-save-mission=${this.onSave} @t-leave=${this.closeForm}></t-mission-form>`)}
    </section>`;
  }

  private renderList({ missions, run }: MissionList, may: boolean): TemplateResult {
    return html`
      ${run === null
        ? nothing
        : html`<section class="sheet" aria-label=${msg("Under way")}>
            <h2>${msg("Under way")}</h2>
            <t-mission-run .run=${run} .zone=${this.zone} ?allowed=${may} @t-act=${this.onAct}></t-mission-run>
          </section>`}
      <section class="sheet" aria-label=${msg("Missions")}>
        <h2>${msg("Missions")}</h2>
        ${missions.length === 0
          ? html`<t-empty heading=${msg("No mission yet")} icon="devices"><p>${may ? msg("Write one: goals, parameters and waits, one after the other.") : msg("Nobody has written one for this site.")}</p></t-empty>`
          : html`<ul>
              ${repeat(missions, ({ id }) => id, (row) => this.renderMission(row, run, may))}
            </ul>`}
      </section>
    `;
  }

  private renderMission(row: MissionRow, run: MissionRunShape | null, may: boolean): TemplateResult {
    const { mission } = row;
    return html`<li class="mission" data-mission=${row.id}>
      <div>
        <h3>${mission.name}</h3>
        ${mission.note === "" ? nothing : html`<p>${mission.note}</p>`}
        <p class="quiet">${plural(mission.steps.length, msg("1 step"), msg(str`${String(mission.steps.length)} steps`))}, ${scheduleText(mission.schedule)}${mission.schedule === null ? "" : msg(str`, with the rights of ${row.owner}`)}${row.due_us > 0 ? msg(html`; next <t-time short .us=${row.due_us} .zone=${this.zone}></t-time>`) : nothing}</p>
        ${row.problem === "" ? nothing : html`<p class="hindrance">${msg(str`Cannot begin now: ${row.problem}.`)}</p>`}
      </div>
      <div class="actions">
        ${may
          ? html`<t-button kind="primary" label=${msg(str`Start ${mission.name}`)} ?disabled=${run !== null || row.problem !== ""} @click=${this.onStart}>${msg("Start")}</t-button>
              <t-button label=${msg(str`Change ${mission.name}`)} @click=${this.onChange}>${msg("Change")}</t-button>`
          : nothing}
        <t-button label=${msg(str`Export ${mission.name}`)} @click=${this.onExport}>${msg("Export")}</t-button>
        ${may ? html`<t-button label=${msg(str`Remove ${mission.name}`)} @click=${this.onRemove}>${msg("Remove…")}</t-button>` : nothing}
      </div>
    </li>`;
  }

  private renderRuns(runs: readonly MissionRunShape[]): unknown {
    const over = runs.filter(({ state: how }) => how !== "running" && how !== "paused");
    if (over.length === 0) return nothing;
    return html`<section class="sheet" aria-label=${msg("Runs")}>
      <h2>${msg("What became of the last ones")}</h2>
      <ul>
        ${repeat(
          over.slice(0, 20),
          ({ id }) => id,
          (run) => html`<li class="mission"><details><summary>${run.name} ${runStatus(run.state)} <span class="quiet"><t-time short .us=${run.began_us} .zone=${this.zone}></t-time>${run.why === "" ? "" : `: ${run.why}`}</span></summary><t-mission-run listed .run=${run} .zone=${this.zone}></t-mission-run></details></li>`,
        )}
      </ul>
    </section>`;
  }

  private renderReading(): unknown {
    const { reading } = this;
    if (reading === null || reading.mission !== null) return nothing;
    return html`<t-problem what=${msg(str`The file is no mission for this site: ${reading.where}: ${reading.problem}.`)} how=${reading.remedy || msg("Mend that place and import it again.")}></t-problem>`;
  }

  private renderRemoval(): TemplateResult {
    const row = this.removing;
    return html`<t-confirm heading=${msg(str`Remove ${row?.mission.name ?? ""}?`)} action=${msg("Remove")} keep=${msg("Keep it")} ?open=${row !== null} @t-close=${this.keepMission} @t-confirm=${this.removeMission}><p>${msg("Its runs stay listed. One that goes on is not ended by it.")}</p></t-confirm>`;
  }

  private reload(): void {
    // A slow answer is waited for: asked anew each second, it would never count.
    if (this.missions.result.state !== "loading") this.missions.invalidate();
    if (this.runs.result.state !== "loading") this.runs.invalidate();
  }

  private async act(what: string, action: () => Promise<unknown>): Promise<boolean> {
    const done = await this.action.run(what, action);
    this.reload();
    return done;
  }

  /** The mission in whose line something was pressed. */
  private rowOf(event: Event): MissionRow | undefined {
    const line = event.currentTarget instanceof Element ? event.currentTarget.closest<HTMLElement>("[data-mission]") : null;
    return this.missions.value?.missions.find(({ id }) => id === line?.dataset["mission"]);
  }

  private readonly openNew = (): void => {
    this.draft = emptyDraft();
  };

  private readonly closeForm = (): void => {
    this.draft = null;
  };

  private readonly onStart = (event: Event): void => {
    const row = this.rowOf(event);
    if (row !== undefined) void this.act(msg("start the mission"), () => this.missionsApi.startMission(row.id));
  };

  private readonly onChange = (event: Event): void => {
    const row = this.rowOf(event);
    if (row !== undefined) this.draft = draftOf(row.id, row.mission);
  };

  private readonly onExport = (event: Event): void => {
    const row = this.rowOf(event);
    if (row !== undefined) void this.exportMission(row);
  };

  private readonly onRemove = (event: Event): void => {
    this.removing = this.rowOf(event) ?? null;
  };

  private readonly keepMission = (): void => {
    this.removing = null;
  };

  private readonly removeMission = (): void => {
    const { removing } = this;
    if (removing !== null) void this.act(msg("remove the mission"), () => this.missionsApi.removeMission(removing.id));
    this.removing = null;
  };

  private readonly onAct = (event: CustomEvent<RunActAsk["act"]>): void => {
    void this.act(msg(str`${event.detail} the mission`), () => this.missionsApi.actOnRun(event.detail));
  };

  private readonly onDraft = (event: CustomEvent<MissionDraft>): void => {
    this.draft = event.detail;
  };

  private readonly onSave = (event: CustomEvent<MissionShape>): void => {
    void this.save(event.detail);
  };

  private async save(mission: MissionShape): Promise<void> {
    const id = this.draft?.id ?? "";
    if (await this.act(msg("save the mission"), () => this.missionsApi.saveMission(id, mission))) this.draft = null;
  }

  private async exportMission(row: MissionRow): Promise<void> {
    await this.action.run(msg("export the mission"), async () => {
      const { text } = await this.missionsApi.writeText(row.id);
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([text], { type: "text/yaml" }));
      link.download = `${row.mission.name.replaceAll(/[^\p{L}\p{N}_-]+/gu, "-")}.yaml`;
      link.click();
      URL.revokeObjectURL(link.href);
    });
  }

  private readonly chooseFile = (): void => {
    this.file.value = "";
    this.file.click();
  };

  private readonly onFile = (): void => {
    const [file] = this.file.files ?? [];
    if (file !== undefined) void this.importFile(file);
  };

  private async importFile(file: File): Promise<void> {
    this.reading = null;
    if (file.size > MOST_BYTES) {
      this.reading = { mission: null, where: file.name, problem: msg("it is longer than 128 KiB"), remedy: msg("Choose the file of a mission.") };
      return;
    }
    const text = await file.text();
    await this.action.run(msg("read the file"), async () => {
      const reading = await this.missionsApi.readText(text);
      this.reading = reading;
      // Into the form: it is kept once the person has looked at it.
      if (reading.mission !== null) this.draft = draftOf("", reading.mission);
    });
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-missions": PageMissions;
  }
}
