"""The archive of pictures: FITS files on disk by night, and what is known of each."""
