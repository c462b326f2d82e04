/** A new password in a form: typed twice, with the rules it has to keep. */

import { msg, str } from "@lit/localize";
import { html, type ReactiveControllerHost, type TemplateResult } from "lit";
import { passwordProblem, passwordRules } from "../../format/password-rules.js";
import "./field.js";
import "./rule-list.js";

export class NewPassword {
  private typed = { password: "", again: "" };
  private problem = "";

  /** @param owner gives the name of whose password it is: it must not be in it */
  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly owner: () => string,
  ) {}

  get value(): string {
    return this.typed.password;
  }

  /** Whether it can be used; if not, the reason stands at its field. */
  validate(): boolean {
    this.problem = passwordProblem(this.rules());
    this.host.requestUpdate();
    return this.problem === "";
  }

  clear(): void {
    this.typed = { password: "", again: "" };
    this.host.requestUpdate();
  }

  /** @param label of the first field */
  render(label: string, hint = ""): TemplateResult {
    return html`<t-field label=${label} hint=${hint} error=${this.problem}>
        <input id="password" type="password" autocomplete="new-password" required @input=${this.onInput} />
      </t-field>
      <t-field label=${msg(str`${label}, once more`)}>
        <input id="again" type="password" autocomplete="new-password" required @input=${this.onInput} />
      </t-field>
      <t-rules .rules=${this.rules()}></t-rules>`;
  }

  private rules(): ReturnType<typeof passwordRules> {
    return passwordRules(this.typed.password, this.owner(), this.typed.again);
  }

  private readonly onInput = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    this.typed = { ...this.typed, [event.target.id]: event.target.value };
    this.problem = "";
    this.host.requestUpdate();
  };
}
