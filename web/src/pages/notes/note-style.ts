/** The words of a note in a list: lines as they were written. */

import { css } from "lit";

export const noteStyle = css`
  .message.note {
    overflow-wrap: anywhere;
    white-space: pre-line;
  }
`;
