"""The explorer: a page in the browser that asks the public verbs and holds no physics.

`view.View` is what a page shows, as a value. Around it: `gestures` change it, `links` and `scripts`
write it, `calls` says which verbs it asks. `tasks` turn these into pieces to be drawn, `jobs` and
`worker` compute them in processes of their own. `session` joins all this for one visitor. These
files know no browser; `panes`, `page` and `server` are made with Bokeh, and ``static`` has what
runs in the browser.
"""
