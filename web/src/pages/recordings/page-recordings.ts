/**
 * Recordings of a site's raw topics and films of its cameras: begin and end one, look at the list,
 * take one away. Long, because the recorder and its list share their words and states.
 */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { QuestionController } from "../../controllers/question.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { renderRows } from "../../elements/layout/rows.js";
import { sheets } from "../../elements/layout/page-sections.js";
import type { StatusKind } from "../../elements/feedback/status.js";
import { formatBytes } from "../../format/bytes.js";
import { formatDuration } from "../../format/duration.js";
import { formatNumber } from "../../format/number.js";
import { isForbidden } from "../../format/error-advice.js";
import { plural } from "../../words/plural.js";
import { apiContext, routerContext, sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import type { HubApi } from "../../wire/hub-api.js";
import { recordingPath, RecordingsApi } from "../../wire/recordings-api.js";
import type { RecorderShape, RecordingListShape, RecordingShape } from "../../generated/api.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/field.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";

/** A recording that begins, comes or ends is seen this soon (s). */
const AGAIN_S = 2;
/** Beside a recording in the history, so much is shown on either side (s). */
const AROUND_S = 10;

const STATES: Readonly<Record<RecordingShape["state"], readonly [StatusKind, string]>> = {
  uploading: ["busy", msg("on its way")],
  complete: ["ok", msg("complete")],
  failed: ["bad", msg("failed")],
};

@customElement("t-page-recordings")
export class PageRecordings extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .span {
        font-weight: var(--t-weight-strong);
      }
      li.named {
        outline: 2px solid var(--t-accent);
        outline-offset: 4px;
      }
      .why {
        overflow-wrap: anywhere;
      }
      .note {
        ${quietText}
        overflow-wrap: anywhere;
      }
      form {
        display: flex;
        flex-wrap: wrap;
        align-items: end;
        gap: var(--t-space-3);
      }
      t-field {
        flex: 1 1 16rem;
        max-inline-size: 30rem;
      }
      .ways {
        gap: var(--t-space-1) var(--t-space-2);
      }
      .ways a {
        padding-inline: var(--t-space-2);
      }
    `,
  ];

  @property() site = "";

  @query("li.named") private readonly atMoment!: HTMLElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly router = new ContextStoreController(this, routerContext);
  /** The moment that the address named last, and whose recording was shown. */
  private shownFor = "";
  private readonly known = new LoadController<RecordingListShape>(this);
  private readonly action = new ActionController(this);
  private readonly removing = new QuestionController<RecordingShape>(this, (row, action) =>
    action.run(msg("delete the recording"), () => new RecordingsApi(this.api).removeRecording(this.site, row.id)).finally(this.known.invalidate),
  );
  private why = "";

  constructor() {
    super();
    new TickerController(this);
  }

  override willUpdate(): void {
    const turn = Math.floor(Date.now() / (AGAIN_S * 1000));
    this.known.load(`${this.site} ${String(turn)}`, () => new RecordingsApi(this.api).listRecordings(this.site));
  }

  /** Brings the recording into view that holds the moment which the address names. */
  override updated(): void {
    const named = this.siteId();
    if (named === this.shownFor || this.atMoment === null) return;
    this.shownFor = named;
    this.atMoment.scrollIntoView({ block: "center" });
  }

  private siteId(): string {
    return new URLSearchParams(this.router.store?.search ?? "").get("at") ?? "";
  }

  override render(): TemplateResult {
    const { result } = this.known;
    return html`${renderPageHead(
        msg("Recordings"),
        msg(html`Raw topics of ${this.sites.store?.siteRow(this.site)?.name ?? this.site} as MCAP files, for Foxglove, Lichtblick and <code>ros2 bag</code>, and films of its cameras, which play beside the history.`),
        html`<a href=${sitePath(this.site, "history")}>${msg("History")}</a>`,
      )}
      ${renderAdvice(this.action.problem)}
      ${result.state === "failed" && isForbidden(result.error)
        ? renderAdvice({ what: msg("You may not see this site's recordings."), how: msg("They hold all of its topics: ask an admin for the right to view the whole site.") })
        : renderLoaded(this.known, msg("the recordings"), (known) => this.renderContent(known))}`;
  }

  private renderContent(known: RecordingListShape): TemplateResult {
    const rows = known.recordings;
    const total = rows.reduce((sum, row) => sum + row.have, 0);
    return html`${this.renderRecorder(known.recorder, known.zone)}
      ${rows.length === 0
        ? html`<t-empty heading=${msg("Nothing was recorded yet")} icon="history">
            <p>${msg("Recordings made at the gateway are uploaded here automatically.")}</p>
          </t-empty>`
        : html`<section class="sheet" aria-label=${msg("Recordings")}>
            <div class="facts"><span>${plural(rows.length, msg("1 recording"), msg(str`${String(rows.length)} recordings`))}</span><span>${formatBytes(total)}</span></div>
            ${renderRows(rows, (row) => this.renderRow(row, known))}
          </section>`}
      ${renderQuestion(this.removing, ({ why }) => ({
        heading: msg("Delete this recording?"),
        action: msg("Delete"),
        text: html`<p>${why}</p>
          <p>${msg("Its file is gone for good then; the history stays.")}</p>`,
      }))}`;
  }

  private renderRecorder(now: RecorderShape, zone: string): TemplateResult {
    if (!now.described) {
      return html`<section class="sheet" aria-label=${msg("Recorder")}>
        <p class="muted">
          ${msg(html`The site description names nothing to record. With <code>recording: {}</code> in it, the gateway holds the last 30 seconds and keeps them when something happens, and films each camera that you ask it to.`)}
        </p>
      </section>`;
    }
    return html`<section class="sheet" aria-label=${msg("Recorder")}>
      <div class="ways">
        ${now.on
          ? html`<t-status kind="busy" word=${msg("recording")}></t-status><span>${msg(html`since <t-time us=${now.since_us} zone=${zone}></t-time>`)}</span>`
          : html`<t-status kind=${now.online ? "unknown" : "offline"} word=${now.online ? msg("not recording") : msg("gateway offline")}></t-status>`}
      </div>
      ${now.on ? html`<p class="why">${now.why}${now.who === "" ? "" : ` · ${now.who}`}</p>` : nothing}
      ${now.filming.length === 0 ? nothing : html`<p class="why">${msg("Filming:")} ${now.filming.join(", ")}</p>`}
      ${now.problem === "" ? nothing : html`<t-problem what=${msg("The last recording failed.")} how=${now.problem}></t-problem>`}
      ${now.may_record && now.topics.length + now.cameras.length > 0 ? this.renderControl(now) : nothing}
      ${now.cameras.length === 0
        ? nothing
        : html`<p class="note">
            ${now.can_film || !now.online
              ? msg(str`Filmed with each recording: ${now.cameras.join(", ")}`)
              : msg(str`Its gateway cannot film ${now.cameras.join(", ")}: install talaia[camera] there.`)}
          </p>`}
      <details ?hidden=${now.topics.length === 0}>
        <summary>${plural(now.topics.length, msg("1 topic"), msg(str`${String(now.topics.length)} topics`))}</summary>
        <p class="note">${now.topics.join(", ")}</p>
      </details>
    </section>`;
  }

  private renderControl(now: RecorderShape): TemplateResult {
    if (now.on) {
      return html`<div class="actions"><t-button kind="primary" ?busy=${this.action.runningKey === "end"} @click=${this.stopRecording}>${msg("End the recording")}</t-button></div>`;
    }
    return html`<form @submit=${this.startRecording}>
      <t-field label=${msg("Why (optional)")}>
        <input maxlength="500" autocomplete="off" .value=${this.why} @input=${this.onInput} ?disabled=${!now.online} />
      </t-field>
      <t-button type="submit" kind="primary" ?disabled=${!now.online} ?busy=${this.action.runningKey === "begin"}>${msg("Record")}</t-button>
    </form>
    <p class="note">
      ${msg(str`It begins ${formatDuration(now.before_s)} ago: so much is held at the gateway at all times.`)}
    </p>`;
  }

  private renderRow(row: RecordingShape, known: RecordingListShape): TemplateResult {
    const [kind, word] = STATES[row.state];
    const { zone, recorder } = known;
    const part = row.size > 0 ? row.have / row.size : 0;
    const told = row.state === "uploading" ? `${word}, ${formatNumber(100 * part, 0)} %` : word;
    const at = this.siteId() === "" ? NaN : Number(this.siteId());
    const named = row.begin_us <= at && at <= row.end_us;
    return html`<li class=${named ? "named" : ""} aria-current=${named ? "true" : nothing}>
      <div>
        <div class="span">
          <t-time us=${row.begin_us} zone=${zone}></t-time> – <t-time us=${row.end_us} zone=${zone}></t-time>
        </div>
        <div class="why">${row.stream === "" ? nothing : html`<strong>${msg(str`Film of ${row.stream}`)}</strong> · `}${row.why}${row.who === "" ? "" : ` · ${row.who}`}</div>
        <div class="facts">
          <t-status kind=${kind} word=${told}></t-status>
          <span>${formatDuration((row.end_us - row.begin_us) / 1e6)}</span>
          <span>${formatBytes(row.size)}</span>
          ${row.messages === 0 ? nothing : html`<span>${formatNumber(row.messages, 0)} ${row.stream === "" ? msg("messages") : msg("pictures")}</span>`}
        </div>
        ${row.note === "" ? nothing : html`<div class="note">${row.note}</div>`}
        ${row.topics.length === 0
          ? nothing
          : html`<details>
              <summary>${plural(row.topics.length, msg("1 topic"), msg(str`${String(row.topics.length)} topics`))}</summary>
              <p class="note">${row.topics.join(", ")}</p>
            </details>`}
      </div>
      <div class="ways">
        ${row.state === "complete"
          ? html`<a href=${recordingPath(this.site, row.id)} download aria-label=${msg(str`Download ${row.id}`)}>${msg("Download")}</a>`
          : nothing}
        <a href=${this.historyAround(row)} aria-label=${row.stream === "" ? msg(str`The history around ${row.id}`) : msg(str`Watch ${row.id}`)}
          >${row.stream === "" ? msg("History") : msg("Watch")}</a
        >
        ${recorder.may_delete
          ? html`<t-button label=${msg(str`Delete ${row.id}`)} @click=${this.removing.opener(row)}>${msg("Delete")}</t-button>`
          : nothing}
      </div>
    </li>`;
  }

  /** The history page at the recording's time. */
  private historyAround(row: RecordingShape): string {
    const from = row.begin_us - AROUND_S * 1e6;
    const to = row.end_us + AROUND_S * 1e6;
    const film = row.stream === "" ? "" : `&at=${String(row.begin_us)}`;
    return `${sitePath(this.site, "history")}?from=${String(from)}&to=${String(to)}${film}`;
  }

  private readonly onInput = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.why = event.target.value;
  };

  private readonly startRecording = (event: Event): void => {
    event.preventDefault();
    const api = new RecordingsApi(this.api);
    void this.action
      .run(msg("begin the recording"), () => api.setRecording(this.site, true, this.why), "", "begin")
      .then((done) => {
        if (done) this.why = "";
        this.known.invalidate();
      });
  };

  private readonly stopRecording = (): void => {
    const api = new RecordingsApi(this.api);
    void this.action.run(msg("end the recording"), () => api.setRecording(this.site, false, ""), "", "end").then(this.known.invalidate);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-recordings": PageRecordings;
  }
}
