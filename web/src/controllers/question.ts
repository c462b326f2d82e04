/** A question about something, asked before it is done; what went wrong is said where it is asked. */

import type { ReactiveControllerHost } from "lit";
import { ActionController } from "./action.js";
import { OpenSubject } from "./open-subject.js";

export class QuestionController<T> extends OpenSubject<T> {
  /**
   * @param perform does what was asked about, and gives whether it was done
   * @param action runs it; one of its own, unless it has to wait for others of the element
   */
  constructor(
    host: ReactiveControllerHost,
    private readonly perform: (subject: T, action: ActionController) => Promise<boolean>,
    readonly action = new ActionController(host),
  ) {
    super(host);
  }

  override open(subject: T): void {
    this.action.clear();
    super.open(subject);
  }

  /** For the button that says yes. */
  readonly confirm = (): void => {
    const { subject } = this;
    if (subject === null) return;
    void this.perform(subject, this.action).then((done) => {
      if (done) this.close();
    });
  };
}
