/** What a detector would have said of the last day, week or month: two settings side by side. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { renderOptions, type SelectOption } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { DAY_US } from "../../series/zone-clock.js";
import { subjectOf, type Detector } from "../../state/anomaly-detectors.js";
import { formText, submittedForm } from "../../format/form-values.js";
import type { BackTestAsk, BackTestShape } from "../../generated/api.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "./test-result.js";

/** What this needs of the hub's HTTP interface. */
export interface TestSource {
  beginTest(ask: BackTestAsk): Promise<BackTestShape>;
  showTest(key: string): Promise<BackTestShape>;
  cancelTest(key: string): Promise<void>;
}

const ASK_MS = 1000;
const WINDOWS: readonly SelectOption[] = [
  ["1", msg("the last day")],
  ["7", msg("the last week")],
  ["30", msg("the last 30 days")],
];
const SETTINGS = ["A", "B"] as const;
/** Detectors of one signal that history can be judged by; limits are set in numbers. */
const OF_ONE: readonly SelectOption[] = [
  ["together", msg("all together")],
  ["change", msg("change of level")],
  ["nearest", msg("nearest stretches")],
  ["season", msg("time of day")],
  ["baseline", msg("robust baseline")],
  ["context", msg("context")],
  ["iqr", msg("quartiles")],
  ["still", msg("flat line")],
  ["rate", msg("rate of change")],
];

@customElement("t-back-test")
export class BackTest extends LitElement {
  static override styles = [
    base,
    control,
    css`
      form {
        display: flex;
        flex-wrap: wrap;
        align-items: end;
        gap: var(--t-space-3) var(--t-space-4);
      }
      t-field {
        flex: 1 1 11rem;
        max-inline-size: 20rem;
      }
      .results {
        display: grid;
        grid-template-columns: repeat(auto-fit, minmax(min(100%, 20rem), 1fr));
        gap: var(--t-space-4) var(--t-space-6);
        margin-block-start: var(--t-space-4);
      }
      .quiet {
        ${quietText}
      }
    `,
  ];

  @property() site = "";
  @property() zone = "UTC";
  @property({ attribute: false }) groups: readonly Detector[] = [];
  /** Numbers of the site: their names by their addresses. */
  @property({ attribute: false }) signals: ReadonlyMap<string, string> = new Map();
  @property({ attribute: false }) hub: TestSource | null = null;

  @state() private subject = "";
  @state() private tests: readonly BackTestShape[] = [];
  @state() private wrong = "";
  @query("form") private readonly form!: HTMLFormElement;
  private readonly action = new ActionController(this);
  private timer: ReturnType<typeof setTimeout> | undefined;

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
  }

  override render(): TemplateResult {
    const subjects: readonly SelectOption[] = [
      ...this.groups.map((group) => [group.address, msg(str`${subjectOf(group)}: signals together`)] as const),
      ...[...this.signals].map(([address, label]) => [address, label] as const),
    ];
    const subject = this.subject === "" ? (subjects[0]?.[0] ?? "") : this.subject;
    const grouped = subject.startsWith("/");
    const busy = this.action.busy || this.tests.some((test) => test.state === "running");
    return html`<form novalidate @submit=${this.onSubmit}>
        <t-field label=${msg("What")}><select name="subject" @change=${this.onSubject}>${renderOptions(subjects, subject)}</select></t-field>
        ${grouped ? nothing : html`<t-field label=${msg("Detector")}><select name="detector">${renderOptions(OF_ONE, "together")}</select></t-field>`}
        <t-field label=${msg("Over")}><select name="days">${renderOptions(WINDOWS, "1")}</select></t-field>
        ${map(SETTINGS, (setting) => this.renderSetting(setting, grouped))}
        <t-button kind="primary" ?disabled=${busy} @click=${this.submit}>${msg("Try both")}</t-button>
      </form>
      ${this.action.problem === null ? nothing : renderAdvice(this.action.problem)}
      <div class="results">
        ${map(
          this.tests,
          (test, place) =>
            html`<t-test-result
              heading=${msg(str`Setting ${SETTINGS[place] ?? ""}`)}
              .site=${this.site}
              .zone=${this.zone}
              .test=${test}
              @t-cancel-test=${this.onCancel}
            ></t-test-result>`,
        )}
      </div>`;
  }

  private renderSetting(setting: string, grouped: boolean): TemplateResult {
    const error = this.wrong === setting ? msg("Expected a number from 0 to 1.") : "";
    return html`<t-field label=${msg(str`${setting}: told from`)} .error=${error}
        ><input name=${`bar${setting}`} inputmode="decimal" autocomplete="off" placeholder=${msg("its own")} .defaultValue=${setting === "A" ? "" : "0.7"}
      /></t-field>
      ${grouped
          ? html`<t-field label=${msg(str`${setting}: learns from (steps)`)}><input name=${`learn${setting}`} inputmode="numeric" autocomplete="off" placeholder=${msg("as described")} /></t-field>`
          : nothing}`;
  }

  private readonly onSubject = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.subject = event.target.value;
  };

  private readonly submit = (): void => {
    this.form.requestSubmit();
  };

  private readonly onSubmit = (event: Event): void => {
    const said = submittedForm(event);
    if (said === undefined) return;
    const text = (name: string): string => formText(said, name);
    const toUs = Math.floor(Date.now() * 1000);
    const window = { from_us: toUs - Number(text("days")) * DAY_US, to_us: toUs };
    const address = text("subject");
    const asks = SETTINGS.map((setting): BackTestAsk => {
      const bar = Number(text(`bar${setting}`).replace(",", "."));
      const plain = { address, detector: address.startsWith("/") ? "group" : text("detector"), ...window, bar };
      return { ...plain, learn: Math.round(Number(text(`learn${setting}`))) };
    });
    const wrong = asks.findIndex(({ bar = 0, learn = 0 }) => !(bar >= 0 && bar <= 1) || Number.isNaN(learn));
    this.wrong = SETTINGS[wrong] ?? "";
    if (this.wrong === "") void this.begin(asks);
  };

  private async begin(asks: readonly BackTestAsk[]): Promise<void> {
    const { hub } = this;
    if (hub === null) return;
    clearTimeout(this.timer);
    this.tests = [];
    await this.action.run(msg("try this detector"), async () => {
      for (const ask of asks) this.tests = [...this.tests, await hub.beginTest(ask)];
    });
    this.waitForNews();
  }

  private waitForNews(): void {
    if (!this.isConnected || this.tests.every((test) => test.state !== "running")) return;
    this.timer = setTimeout(() => void this.askAgain(), ASK_MS);
  }

  private async askAgain(): Promise<void> {
    const { hub, tests } = this;
    if (hub === null) return;
    // One that cannot be asked for now stays as it was, and is asked for again.
    const news = await Promise.all(tests.map(async (test) => (test.state === "running" ? hub.showTest(test.key).catch(() => test) : test)));
    if (this.tests !== tests) return;
    this.tests = news;
    this.waitForNews();
  }

  private readonly onCancel = (event: CustomEvent<string>): void => {
    event.stopPropagation();
    void this.cancel(event.detail);
  };

  private async cancel(key: string): Promise<void> {
    const { hub } = this;
    if (hub === null) return;
    await this.action.run(msg("cancel the test"), () => hub.cancelTest(key));
    clearTimeout(this.timer);
    await this.askAgain();
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-back-test": BackTest;
  }
}
